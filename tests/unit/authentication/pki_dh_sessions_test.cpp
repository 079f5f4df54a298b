// What a finished handshake gives out, and for how long.
#include "plugins/authentication/pki_dh.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST(PkiDhSessions, TheCredential_IsDroppedOnceItWasGivenOut) {
  Pairing pairing;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  ASSERT_OK(reply);
  pairing.expect_finish(*request, *reply);
  auto& low = *pairing.two.low.plugin;
  low->poll();  // must not expire the credential before it was given out
  EXPECT_TRUE(low->authenticated_peer_credential_token(request->handle));
  EXPECT_TRUE(low->authenticated_peer_credential_token(request->handle));
  low->poll();
  EXPECT_CODE(low->authenticated_peer_credential_token(request->handle), credential_given_out);
  EXPECT_TRUE(low->shared_secret(request->handle));
  // Another handshake has a credential of its own.
  const auto again = pairing.two.request();
  const auto answer = pairing.two.reply(*again->message);
  pairing.expect_finish(*again, *answer);
  EXPECT_TRUE(low->authenticated_peer_credential_token(again->handle));
}

TEST(PkiDhSessions, Secret_OutlivesTheHandle) {
  Pairing pairing;
  const auto request = pairing.two.request();
  const auto reply = pairing.two.reply(*request->message);
  const auto final_message = pairing.two.process_at_lower_guid(request->handle, *reply->message);
  ASSERT_OK(final_message);
  auto& plugin = *pairing.two.low.plugin;
  const auto secret = plugin->shared_secret(request->handle);
  ASSERT_OK(secret);
  ASSERT_OK(plugin->return_handshake_handle(request->handle));
  EXPECT_CODE(plugin->shared_secret(request->handle), unknown_handshake);
  ASSERT_OK(plugin->return_identity_handle(pairing.two.high_at_low));
  EXPECT_EQ((*secret)->secret.size(), 32u);
}

}  // namespace
}  // namespace ddssec::authentication
