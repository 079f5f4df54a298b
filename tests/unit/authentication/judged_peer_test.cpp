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
    ASSERT_OK((*p->engine)->set_permissions_credential_and_token(p->handle, credential, {}));
  const auto req = pairing.two.request();
  ASSERT_OK(req);
  EXPECT_EQ(as_text(field(*req->message, "c.perm")), "MIME text");
  const auto rep = pairing.two.reply(*req->message);
  ASSERT_OK(rep);
  pairing.expect_finish(*req, *rep);
  const auto at_low = (*pairing.two.low.engine)->authenticated_peer_credential_token(req->handle);
  const auto at_high = (*pairing.two.high.engine)->authenticated_peer_credential_token(rep->handle);
  ASSERT_OK(at_low);
  ASSERT_OK(at_high);
  EXPECT_EQ(at_low->class_id, "DDS:Auth:PKI-DH:1.0");
  EXPECT_TRUE((*pairing.two.low.engine)->authenticated_subject(req->handle).starts_with("CN="));
  for (const auto& token : {*at_low, *at_high})
    EXPECT_EQ(as_text(field(token, "c.perm")), "MIME text");
  EXPECT_EQ(field(*at_high, "c.id"), field(*req->message, "c.id"));
  EXPECT_EQ(field(*at_low, "c.id"), field(*rep->message, "c.id"));
}

// Returns the ciphers that each side believes the other one can decrypt, after a handshake in which
// discovery's tokens were replaced by `announced`, if there is one.
std::pair<spi::CipherMask, spi::CipherMask> ciphers_after(const Token* announced) {
  Engine first{1}, second{2};
  Participant able(first, make_identity(test_ca(), "CN=alice,O=Example"), 1, spi::kAllCiphers);
  Participant plain(second, make_identity(test_ca(), "CN=bob,O=Example", {}, kYear, 1), 2);
  if (announced != nullptr) able.token = *announced;
  Two two(able, plain);
  const auto req = two.request();
  const auto rep = two.reply(*req->message);
  const auto fin = two.at_low(req->handle, *rep->message);
  EXPECT_TRUE(two.at_high(rep->handle, *fin->message));
  const auto at = [&](Participant& one) {
    const auto handle = &one == &two.low ? req->handle : rep->handle;
    return (*one.engine)->shared_secret(handle).value()->peer_ciphers;
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
