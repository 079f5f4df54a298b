// Handshakes under way while a certificate is renewed.
#include "plugins/spi/session_facts.hpp"
#include "tests/unit/authentication/renewal_fixture.hpp"

namespace ddssec::authentication {
namespace {

TEST_F(Renewal, HandshakeUnderWay_GoesOnWithWhatItBeganWith) {
  const auto request = pairing_.two.request();
  ASSERT_OK(request);
  const auto reply = pairing_.two.reply(*request->message);
  ASSERT_OK(reply);
  put(renewed(3));
  EXPECT_THAT(poll(), IsEmpty());
  EXPECT_EQ(events().back().error.code(), Code::identity_renewed);
  pairing_.expect_finish(*request, *reply);
}

// Alice with a peer whose GUID is higher or lower than hers.
struct Chosen {
  Chosen(Participant& alice, bool alice_begins)
      : peer(plugin, choose(alice, alice_begins), 20), two(alice, peer) {}
  static Identity choose(const Participant& alice, bool alice_begins) {
    for (int i = 0;; ++i) {
      auto identity = make_identity(long_lived_ca(), "CN=peer" + std::to_string(i), {}, kYear, 1);
      const auto guid = adjusted_guid(identity.certificate.subject_digest(), candidate(20));
      if ((alice.guid < guid) == alice_begins) return identity;
    }
  }
  TestPlugin plugin{7};
  Participant peer;
  Two two;
};

TEST_F(Renewal, RequestThatWasSent_IsRepeatedForAWhileAndThenMadeAnew) {
  Chosen with(pairing_.a, true);
  const auto first = with.two.request();
  ASSERT_OK(first);
  const auto next = renewed(3);
  put(next);
  plugin().clock.advance(1s);
  plugin()->poll();
  EXPECT_EQ(events().back().error.code(), Code::identity_renewed);
  EXPECT_EQ(with.two.request()->handle, first->handle);
  plugin().clock.advance(kPendingAge);
  const auto second = with.two.request();
  ASSERT_OK(second);
  EXPECT_NE(second->handle, first->handle);
  EXPECT_EQ(as_text(field(*second->message, "c.id")), next.certificate.pem());
  const auto reply = with.two.reply(*second->message);
  ASSERT_OK(reply);
  pairing_.expect_finish_of(with.two, *second, *reply);
}

TEST_F(Renewal, RequestThatComesAgain_IsAnsweredAnewAfterAWhile) {
  Chosen with(pairing_.a, false);
  const auto request = with.two.request();
  const auto first = with.two.reply(*request->message);
  ASSERT_OK(first);
  const auto next = renewed(3);
  put(next);
  plugin().clock.advance(1s);
  plugin()->poll();
  EXPECT_EQ(with.two.reply(*request->message)->handle, first->handle);
  plugin().clock.advance(kPendingAge);
  const auto second = with.two.reply(*request->message);
  ASSERT_OK(second);
  EXPECT_NE(second->handle, first->handle);
  EXPECT_EQ(as_text(field(*second->message, "c.id")), next.certificate.pem());
  pairing_.expect_finish_of(with.two, *request, *second);
}

TEST_F(Renewal, PermissionsAndCertificate_AreNeverMixed) {
  const auto request = pairing_.two.request();
  const auto reply = pairing_.two.reply(*request->message);
  ASSERT_OK(reply);
  ASSERT_OK(plugin()->set_permissions_credential_and_token(
      pairing_.a.handle,
      {std::string(spi::class_id::kPermissionsCredential), {{"dds.perm.cert", "<new/>"}}, {}}, {}));
  put(renewed(3));
  poll();
  pairing_.expect_finish(*request, *reply);
}

TEST_F(Renewal, Credential_NamesWhatEachPeerWasPresented) {
  for (const auto& [vendor, keeps] : {std::pair(kCycloneDds, false), {kFastDds, true}}) {
    Pairing pairing;
    ASSERT_OK((*pairing.two.low.plugin)
                  ->set_permissions_credential_and_token(
                      pairing.two.low.handle,
                      {.class_id = std::string(spi::class_id::kPermissionsCredential),
                       .properties = {{"dds.perm.cert", "a document"}}},
                      {}));
    auto& high = pairing.two.high;
    high.data = participant_data(high.guid, &high.token, vendor);
    const auto request = pairing.two.request();
    ASSERT_OK(request);
    const auto reply = pairing.two.reply(*request->message);
    ASSERT_OK(reply);
    pairing.expect_finish(*request, *reply);
    const auto credential =
        (*pairing.two.low.plugin)->authenticated_peer_credential_token(request->handle);
    ASSERT_OK(credential);
    const auto facts = spi::session_facts_in(*credential);
    EXPECT_EQ(facts.presented_permissions, sha256(as_bytes("a document")));
    EXPECT_EQ(facts.peer_keeps_session, keeps);
    Writer sent(Endian::big);
    spi::write_token(sent, *credential);
    EXPECT_EQ(as_text(sent.take()).find("org.ddssec"), std::string_view::npos);
  }
}

}  // namespace
}  // namespace ddssec::authentication
