// What is known about an authenticated peer: its permissions, its ciphers, its credential.
#include "plugins/authentication/judged_peer.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(JudgedPeer, Permissions_TravelBothWays) {
  Pairing pairing;
  const Token credential{"DDS:Access:PermissionsCredential",
                         {{"dds.perm.cert", std::string("MIME text\0", 10)}}};
  for (auto* p : {&pairing.a, &pairing.b})
    ASSERT_OK((*p->plugin)->set_permissions_credential_and_token(p->handle, credential, {}));
  const auto request = pairing.two.request();
  ASSERT_OK(request);
  EXPECT_EQ(as_text(field(*request->message, "c.perm")), "MIME text");
  const auto reply = pairing.two.reply(*request->message);
  ASSERT_OK(reply);
  pairing.expect_finish(*request, *reply);
  const auto process_at_lower_guid =
      (*pairing.two.low.plugin)->authenticated_peer_credential_token(request->handle);
  const auto process_at_higher_guid =
      (*pairing.two.high.plugin)->authenticated_peer_credential_token(reply->handle);
  ASSERT_OK(process_at_lower_guid);
  ASSERT_OK(process_at_higher_guid);
  EXPECT_EQ(process_at_lower_guid->class_id, "DDS:Auth:PKI-DH:1.0");
  EXPECT_TRUE((*pairing.two.low.plugin)->authenticated_subject(request->handle).starts_with("CN="));
  for (const auto& token : {*process_at_lower_guid, *process_at_higher_guid})
    EXPECT_EQ(as_text(field(token, "c.perm")), "MIME text");
  EXPECT_EQ(field(*process_at_higher_guid, "c.id"), field(*request->message, "c.id"));
  EXPECT_EQ(field(*process_at_lower_guid, "c.id"), field(*reply->message, "c.id"));
}

// Returns the ciphers that each side believes the other one can decrypt, after a handshake in which
// discovery's tokens were replaced by `announced`, if there is one.
std::pair<spi::CipherMask, spi::CipherMask> ciphers_after(const Token* announced) {
  TestPlugin first{1}, second{2};
  Participant able(first, make_identity(test_ca(), "CN=alice,O=Example"), 1, spi::kAllCiphers);
  Participant plain(second, make_identity(test_ca(), "CN=bob,O=Example", {}, kYear, 1), 2);
  if (announced != nullptr) able.token = *announced;
  Two two(able, plain);
  const auto request = two.request();
  const auto reply = two.reply(*request->message);
  const auto final_message = two.process_at_lower_guid(request->handle, *reply->message);
  EXPECT_TRUE(two.process_at_higher_guid(reply->handle, *final_message->message));
  const auto at = [&](Participant& one) {
    const auto handle = &one == &two.low ? request->handle : reply->handle;
    return (*one.plugin)->shared_secret(handle).value()->peer_ciphers;
  };
  return {at(plain), at(able)};
}

TEST(JudgedPeer, Ciphers_AreToldToEachSide) {
  const std::pair right{spi::kAllCiphers, spi::kStandardCiphers};
  EXPECT_EQ(ciphers_after(nullptr), right);
  // Discovery is not proven, so what it brought neither takes ciphers away nor adds any.
  const Token bare{std::string(spi::class_id::kIdentity)};
  EXPECT_EQ(ciphers_after(&bare), right);
}

}  // namespace
}  // namespace ddssec::authentication
