// Handles that were returned or never given out, and the limits for identities and handshakes.
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(IdentityHandles, UnknownOrReturnedHandles_AreRefused) {
  Pairing pairing;
  auto& two = pairing.two;
  auto& plugin = *two.low.plugin;
  const HandshakeHandle unknown{99};
  EXPECT_CODE(plugin->process_handshake(unknown, {}), unknown_handshake);
  EXPECT_CODE(plugin->shared_secret(unknown), unknown_handshake);
  EXPECT_CODE(plugin->authenticated_peer_credential_token(unknown), unknown_handshake);
  EXPECT_CODE(plugin->return_handshake_handle(unknown), unknown_handshake);
  EXPECT_CODE(plugin->return_identity_handle({99}), unknown_identity);
  EXPECT_CODE(plugin->identity_token({99}), unknown_identity);
  EXPECT_CODE(plugin->identity_status_token({}), unknown_identity);
  EXPECT_CODE(plugin->begin_handshake_request(two.low.handle, {99}, two.low.data),
              unknown_identity);
  EXPECT_CODE(plugin->begin_handshake_request({99}, two.high_at_low, two.low.data),
              unknown_identity);
  // The handle of a local identity is not accepted as that of a remote one.
  EXPECT_CODE(plugin->begin_handshake_request(two.low.handle, two.low.handle, two.low.data),
              unknown_identity);
}

TEST(IdentityHandles, ReturningTheRemote_DropsItsHandshakes) {
  Pairing pairing;
  auto& two = pairing.two;
  auto& plugin = *two.low.plugin;
  const auto request = two.request();
  ASSERT_OK(request);
  ASSERT_OK(plugin->return_identity_handle(two.high_at_low));
  EXPECT_CODE(two.process_at_lower_guid(request->handle, {}), unknown_handshake);
  EXPECT_CODE(plugin->return_identity_handle(two.high_at_low), unknown_identity);
  EXPECT_CODE(two.request(), unknown_identity);
}

TEST(IdentityHandles, ReturningTheLocal_DropsItsHandshakes) {
  Pairing pairing;
  auto& two = pairing.two;
  auto& plugin = *two.low.plugin;
  const auto request = two.request();
  ASSERT_OK(request);
  ASSERT_OK(plugin->return_identity_handle(two.low.handle));
  EXPECT_CODE(two.process_at_lower_guid(request->handle, {}), unknown_handshake);
  EXPECT_FALSE(plugin->next_expiry());
}

TEST(IdentityHandles, ARemoteThatWasNotValidatedForThisLocal_IsUnknown) {
  Pairing pairing;
  Participant second(*pairing.two.low.plugin, make_identity(test_ca(), "CN=second"), 5);
  EXPECT_CODE((*pairing.two.low.plugin)
                  ->begin_handshake_request(second.handle, pairing.two.high_at_low, second.data),
              unknown_identity);
}

// ---- bounds

TEST(IdentityTableBounds, TooManyLocalIdentities_AreRefused) {
  TestPlugin plugin(1, {.max_local_identities = 1});
  const auto identity = make_identity(test_ca(), "CN=ours");
  Participant us(plugin, identity, 1);
  EXPECT_CODE(plugin->validate_local_identity(0, identity.properties, candidate(2)),
              too_many_local_identities);
}

TEST(IdentityTableBounds, PendingReplies_GiveWayToTheHonestOneInTime) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto request = two.request();
  for (std::uint8_t i = 0; i < kMaxPendingPerPair; ++i)
    ASSERT_OK(two.reply(forged(*request->message, i)));
  EXPECT_CODE(two.reply(*request->message), too_many_handshakes);
  two.high.plugin->clock.advance(kPendingAge);
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  pairing.expect_finish(*request, *reply);
}

TEST(IdentityTableBounds, FinishedHandshakesOfAPair_AreFew) {
  Pairing pairing;
  std::vector<HandshakeHandle> handles;
  for (int i = 0; i < 10; ++i) {
    const auto request = pairing.two.request();
    const auto reply = pairing.two.reply(*request->message);
    ASSERT_OK(reply);
    pairing.expect_finish(*request, *reply);
    handles.push_back(request->handle);
  }
  std::size_t known = 0;
  for (const auto handle : handles)
    known += (*pairing.two.low.plugin)->shared_secret(handle).has_value();
  EXPECT_LE(known, 5u);
  EXPECT_TRUE((*pairing.two.low.plugin)->shared_secret(handles.back()));
}

}  // namespace
}  // namespace ddssec::authentication
