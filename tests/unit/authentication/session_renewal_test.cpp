// A renewed certificate is presented to a peer within the session.
#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

using std::chrono::days;
using testing::IsEmpty;

constexpr auto kAlice = "CN=alice,O=Example";
constexpr pki::Validity kShort{kNow - 24h, kNow + days(10)};
constexpr pki::Validity kLong{kNow, kNow + days(100)};

const Identity& first_of_alice() {
  static const auto identity = make_identity(test_ca(), kAlice, {}, kShort);
  return identity;
}
Identity renewed(int key = 0, pki::Validity validity = kLong, std::string subject = kAlice,
                 const pki::Authority& ca = test_ca()) {
  return make_identity(ca, std::move(subject), {}, validity, key);
}

// Alice has files, and Bob has none. They have a session.
class SessionRenewal : public testing::Test {
 protected:
  SessionRenewal()
      : certificate_path_(folder_.write("cert.pem", first_of_alice().certificate.pem())),
        key_path_(folder_.write("key.pem", pem_text(first_of_alice().key))),
        pairing_(with_files(), make_identity(test_ca(), "CN=bob,O=Example", {}, kYear, 1)) {
    std::tie(at_alice_, at_bob_) = shake_hands();
  }

  Identity with_files() const {
    auto identity = first_of_alice();
    set(identity.properties, spi::property::kIdentityCertificate, "file:" + certificate_path_);
    set(identity.properties, spi::property::kPrivateKey, "file:" + key_path_);
    return identity;
  }
  // Returns the handles at Alice and at Bob.
  std::pair<HandshakeHandle, HandshakeHandle> shake_hands() {
    auto& two = pairing_.two;
    const auto request = two.request().value();
    const auto reply = two.reply(*request.message).value();
    pairing_.expect_finish(request, reply);
    const bool begins = &two.low == &pairing_.a;
    return begins ? std::pair(request.handle, reply.handle)
                  : std::pair(reply.handle, request.handle);
  }
  // Puts a renewed certificate in place. From now on Alice presents it.
  void put(const Identity& identity) {
    folder_.replace("cert.pem", identity.certificate.pem());
    folder_.replace("key.pem", pem_text(identity.key));
    for (int i = 0; i < 2; ++i) {
      alice().clock.advance(5s);
      bob().clock.advance(5s);
      alice()->poll();
    }
  }
  std::optional<Token> offer() {
    auto offered = alice()->offer_renewal(at_alice_).value();
    if (!offered) return std::nullopt;
    return std::move(offered->token);
  }
  // Does what both hosts do for a renewal.
  void renew() {
    const auto shown = offer();
    ASSERT_TRUE(shown);
    ASSERT_OK(bob()->judge_renewal(at_bob_, *shown));
    const auto answer = bob()->accept_renewal(at_bob_, *shown);
    ASSERT_OK(answer);
    ASSERT_OK(alice()->note_renewal_accepted(at_alice_, *answer));
  }
  // Expects that Bob's side refuses the offer, reports it, and stays as before.
  void expect_refused(const Token& offer, Code code) {
    bob().events.all.clear();
    const auto judged = bob()->judge_renewal(at_bob_, offer);
    const auto taken = bob()->accept_renewal(at_bob_, offer);
    ASSERT_FALSE(judged || taken);
    EXPECT_EQ(judged.error().code(), code);
    EXPECT_EQ(taken.error().code(), code);
    ASSERT_FALSE(bob().events.all.empty());
    EXPECT_EQ(bob().events.all.front().error.code(), code);
    EXPECT_EQ(bob().events.all.front().peer_subject, kAlice);
    EXPECT_EQ(bob()->next_expiry(), kShort.not_after);
  }
  std::vector<IdentityHandle> ended(TestPlugin& plugin, WallTime at) {
    plugin.clock.advance(at - plugin.clock.calendar_seconds());
    return plugin->poll();
  }
  TestPlugin& alice() { return pairing_.first_plugin; }
  TestPlugin& bob() { return pairing_.second_plugin; }

  const test::TemporaryFolder folder_;
  const std::string certificate_path_, key_path_;
  Pairing pairing_;
  HandshakeHandle at_alice_, at_bob_;
};

TEST_F(SessionRenewal, UnchangedCertificate_IsNotOffered) { EXPECT_FALSE(offer()); }

TEST_F(SessionRenewal, TakenByThePeer_TheSessionOutlivesTheFormerCertificateOnBothSides) {
  put(renewed(3));
  renew();
  EXPECT_FALSE(offer()) << "the peer has it";
  EXPECT_EQ(bob()->next_expiry(), kLong.not_after);
  EXPECT_EQ(bob().events.all.back().error.code(), Code::peer_identity_renewed);
  const auto after = kShort.not_after + 1h;
  EXPECT_THAT(ended(alice(), after), IsEmpty());
  EXPECT_THAT(ended(bob(), after), IsEmpty());
  EXPECT_THAT(ended(bob(), kLong.not_after + 1s), testing::SizeIs(1)) << "its own end counts";
}

TEST_F(SessionRenewal, NotAnswered_EndsWithTheFormerCertificateOnBothSides) {
  put(renewed(3));
  const auto after = kShort.not_after + 1h;
  EXPECT_THAT(ended(alice(), after), testing::SizeIs(1));
  EXPECT_THAT(ended(bob(), after), testing::SizeIs(1));
}

TEST_F(SessionRenewal, TheSameDocuments_AreOfferedAtGrowingIntervals) {
  put(renewed(3));
  int times = 0;
  for (const auto interval : {10s, 10s, 60s, 120s, 240s, 480s, 600s, 600s}) {
    const auto offered = alice()->offer_renewal(at_alice_).value();
    ASSERT_TRUE(offered) << times;
    EXPECT_EQ(offered->times, ++times);
    EXPECT_FALSE(offer());
    alice().clock.advance(interval - 1s);
    EXPECT_FALSE(offer()) << interval.count() << " s after offer " << times;
    alice().clock.advance(1s);
  }
  put(renewed(4, {kNow + 1s, kNow + days(200)}));
  EXPECT_EQ(alice()->offer_renewal(at_alice_).value()->times, 1);
  EXPECT_FALSE(offer());
}

TEST_F(SessionRenewal, AfterManyOffersWithoutAnAnswer_ThePeerStillAccepts) {
  put(renewed(3));
  for (int i = 0; i < 100; ++i) {
    ASSERT_TRUE(offer()) << i;
    alice().clock.advance(600s);
  }
  renew();
  EXPECT_EQ(bob()->next_expiry(), kLong.not_after);
}

TEST_F(SessionRenewal, SecondRenewal_IsTakenToo) {
  put(renewed(3));
  renew();
  put(renewed(4, {kNow + 1s, kNow + days(200)}));
  renew();
  EXPECT_EQ(bob()->next_expiry(), kNow + days(200));
}

// Otherwise the peer could go back to a certificate whose key was replaced for a reason.
TEST_F(SessionRenewal, AnOlderCertificateThanTheOneInForce_IsRefused) {
  put(renewed(3));
  const auto first = *offer();
  put(renewed(4, {kNow + 1s, kNow + days(200)}));
  renew();
  bob().events.all.clear();
  EXPECT_CODE(bob()->accept_renewal(at_bob_, first), peer_renewal_goes_back);
  EXPECT_FALSE(bob().events.all.empty());
  EXPECT_EQ(bob()->next_expiry(), kNow + days(200));
}

TEST_F(SessionRenewal, AnAnswerToAFormerOffer_IsRefused) {
  put(renewed(3));
  const auto first = offer();
  const auto answer = bob()->accept_renewal(at_bob_, *first).value();
  put(renewed(4, {kNow + 1s, kNow + days(200)}));
  ASSERT_TRUE(offer());
  EXPECT_CODE(alice()->note_renewal_accepted(at_alice_, answer), unexpected_message);
}

TEST_F(SessionRenewal, AnAnswerWithoutAnOffer_IsRefused) {
  put(renewed(3));
  const auto answer = bob()->accept_renewal(at_bob_, *offer()).value();
  EXPECT_CODE(bob()->note_renewal_accepted(at_bob_, answer), unexpected_message);
}

TEST_F(SessionRenewal, AnyOctetChanged_IsRefused) {
  put(renewed(3));
  const auto honest = *offer();
  expect_refused(with(honest, "c.perm", bytes("other permissions")), Code::signature_invalid);
  expect_refused(with(honest, "signature", flipped(field(honest, "signature"), 9)),
                 Code::signature_invalid);
  for (const auto* name : {"c.id", "c.perm", "signature"})
    expect_refused(without(honest, name), Code::token_field_missing);
}

TEST_F(SessionRenewal, TheCertificateWithoutItsKey_IsRefused) {
  put(renewed(3));
  // The peer has seen such a certificate, but does not have its key, so the signature is by another
  // key.
  const auto stolen = renewed(4, {kNow, kNow + days(90)});
  expect_refused(with(*offer(), "c.id", bytes(stolen.certificate.pem())), Code::signature_invalid);
}

TEST_F(SessionRenewal, AnotherSession_IsRefused) {
  put(renewed(3));
  const auto of_former = *offer();
  std::tie(at_alice_, at_bob_) = shake_hands();
  bob().events.all.clear();
  EXPECT_CODE(bob()->accept_renewal(at_bob_, of_former), signature_invalid);
}

TEST_F(SessionRenewal, SentBackToItsSender_IsRefused) {
  put(renewed(3));
  EXPECT_CODE(alice()->accept_renewal(at_alice_, *offer()), guid_not_bound_to_subject);
}

TEST_F(SessionRenewal, UnknownCa_IsRefused) {
  static const auto other = make_ca();
  put(renewed(3));
  const auto forged = renewed(3, kLong, kAlice, other);
  expect_refused(with(*offer(), "c.id", bytes(forged.certificate.pem())), Code::issuer_unknown);
}

TEST_F(SessionRenewal, AnotherSubject_IsRefused) {
  put(renewed(3));
  const auto other = renewed(3, kLong, "CN=mallory,O=Example");
  expect_refused(with(*offer(), "c.id", bytes(other.certificate.pem())),
                 Code::guid_not_bound_to_subject);
}

TEST_F(SessionRenewal, EndedCertificate_IsRefused) {
  put(renewed(3, {kNow, kShort.not_after + 1h}));
  const auto shown = *offer();
  bob().clock.advance(days(10) + 2h);
  expect_refused(shown, Code::certificate_expired);
}

TEST_F(SessionRenewal, BeforeTheHandshakeIsFinished_IsAnError) {
  Pairing other;
  const auto request = other.two.request().value();
  EXPECT_CODE(other.two.low.plugin->plugin->offer_renewal(request.handle), handshake_not_finished);
  EXPECT_CODE(alice()->offer_renewal({9999}), unknown_handshake);
}

}  // namespace
}  // namespace ddssec::authentication
