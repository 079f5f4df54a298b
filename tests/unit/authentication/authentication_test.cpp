// Remote identities: which are refused, and what an event says about them.
#include "plugins/authentication/authentication.hpp"

#include "tests/unit/authentication/authentication_fixture.hpp"
#include "tests/unit/authentication/forgeries.hpp"

namespace ddssec::authentication::forgeries {
namespace {

TEST(RemoteIdentity, InvalidTokensAndGuids_AreRefusedWithTheirCodes) {
  Pairing pairing;
  auto& a = pairing.a;
  auto& plugin = *a.plugin;
  Token wrong = pairing.b.token;
  wrong.class_id = "DDS:Auth:PKI-DH:2.0";
  EXPECT_CODE(plugin->validate_remote_identity(a.handle, {}, wrong, candidate(0x85)),
              token_class_wrong);
  EXPECT_CODE(plugin->validate_remote_identity(a.handle, {}, pairing.b.token, candidate(0x05)),
              guid_not_adjusted);
  EXPECT_CODE(plugin->validate_remote_identity(a.handle, {}, pairing.b.token, a.guid),
              remote_guid_is_local);
  EXPECT_CODE(plugin->validate_remote_identity({99}, {}, pairing.b.token, pairing.b.guid),
              unknown_identity);
}

TEST(RemoteIdentity, AnotherToken_ChangesNothingThatAHandshakeProved) {
  Pairing pairing;
  auto& two = pairing.two;
  auto& plugin = *two.low.plugin;
  Token other = two.high.token;
  other.properties[0].value = "/CN=forged";
  const auto replaced = plugin->validate_remote_identity(two.low.handle, {}, other, two.high.guid);
  ASSERT_OK(replaced);
  EXPECT_EQ(replaced->handle, two.high_at_low);
  ASSERT_OK(two.low.discover(two.high));
  pairing.expect_success();
  const auto repeated = plugin->validate_remote_identity(two.low.handle, {}, other, two.high.guid);
  ASSERT_OK(repeated);
  EXPECT_EQ(repeated->handle, two.high_at_low);
  // The identity with the same token is still the same one. After it left, a restarted peer may
  // come with another token.
  ASSERT_OK(two.low.discover(two.high));
  ASSERT_OK(plugin->return_identity_handle(two.high_at_low));
  const auto fresh = plugin->validate_remote_identity(two.low.handle, {}, other, two.high.guid);
  ASSERT_OK(fresh);
  EXPECT_NE(fresh->handle, two.high_at_low);
}

TEST(RemoteIdentity, IdentityOfAnotherCa_IsRefused) {
  static const pki::Authority other_ca = make_ca("CN=Other CA");
  Pairing pairing(make_identity(test_ca(), "CN=alice"),
                  make_identity(other_ca, "CN=bob", {}, kYear, 1));
  const auto request = pairing.two.request();
  EXPECT_CODE(pairing.two.reply(*request->message), issuer_unknown);
}

// Once the subject is proven, the event has its name.
TEST(RemoteIdentity, RefusalAfterProof_NamesThePeerInItsEvent) {
  Pairing pairing;
  pairing.expect_success();
  auto& two = pairing.two;
  EXPECT_CODE(two.reply(Token{"DDS:Auth:PKI-DH:1.0+Req"}), token_field_missing);
  const auto& event = two.high.plugin->events.all.back();
  EXPECT_EQ(event.peer_subject, &two.low == &pairing.a ? "CN=alice,O=Example" : "CN=bob,O=Example");
  EXPECT_EQ(event.guid, two.low.guid.to_string());
}

}  // namespace
}  // namespace ddssec::authentication::forgeries
