// Peers whose certificates end, and that stay because a renewal list has their later ones.
#include "plugins/authentication/listed_identities.hpp"

#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/listed.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication::listed {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// ---- what keeps a peer

TEST_F(Listed, CertificateOfTheSameKey_KeepsThePeer) {
  put(list_of({renewed_bob()}));
  EXPECT_THAT(poll(), IsEmpty());
  ASSERT_THAT(codes(), ElementsAre(Code::renewal_list_taken));
  EXPECT_EQ(plugin()->next_expiry(), kShort.not_after);
  EXPECT_THAT(pass_the_end(), IsEmpty());
  ASSERT_EQ(events().size(), 1u);
  const auto& event = events().front();
  EXPECT_EQ(event.error.code(), Code::peer_renewal_listed);
  EXPECT_EQ(event.severity, Severity::informational);
  EXPECT_EQ(event.peer_subject, kBob);
  EXPECT_EQ(event.guid, pairing_.b.guid.to_string());
  EXPECT_EQ(event.error.details().found, to_string(kNext.not_after));
  EXPECT_EQ(plugin()->next_expiry(), kNext.not_after);
}

TEST_F(Listed, ThePeerThatIsKept_EndsWithItsLaterCertificate) {
  put(list_of({renewed_bob(1, {kNow + 5s, kNow + 40s})}));
  poll();
  EXPECT_THAT(poll(16s), IsEmpty());
  EXPECT_THAT(poll(18s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_taken, Code::peer_renewal_listed,
                                   Code::identity_ended));
}

TEST_F(Listed, ASecondRenewal_KeepsThePeerAgain) {
  put(list_of({renewed_bob(1, {kNow + 5s, kNow + 40s})}));
  poll(21s);
  put(list_of({renewed_bob(1, {kNow + 30s, kNow + 24h})}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_EQ(plugin()->next_expiry(), kNow + 24h);
}

TEST_F(Listed, ListThatArrivesInTheLastSecond_KeepsThePeer) {
  poll(19s);
  put(list_of({renewed_bob()}));
  EXPECT_THAT(poll(1s), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_taken, Code::peer_renewal_listed));
}

// ---- what does not keep it

TEST_F(Listed, PeerWithoutAList_EndsInTime) {
  EXPECT_THAT(poll(19s), IsEmpty());
  EXPECT_THAT(poll(1s), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), ElementsAre(Code::identity_ended));
}

TEST_F(Listed, AListThatComesAfterTheEnd_BringsNoOneBack) {
  poll(20s);
  put(list_of({renewed_bob()}));
  poll();
  EXPECT_THAT(codes(), ElementsAre(Code::identity_ended, Code::renewal_list_taken));
  EXPECT_CODE(pairing_.a.discover(pairing_.b), identity_ended);
}

// ---- our own certificate, which a peer has seen

// Bob has files. His certificate ends, and is renewed in time.
class OwnListed : public testing::Test {
 protected:
  explicit OwnListed(spi::CipherMask ciphers = spi::kAllCiphers)
      : alice_(first_, make_identity(test_ca(), kAlice), 1, ciphers),
        bob_(second_, with_files(), 2),
        two_(alice_, bob_) {}

  Identity with_files() const {
    auto identity = bob_with(kShort);
    set(identity.properties, property::kIdentityCertificate,
        "file:" + folder_.write("cert.pem", identity.certificate.pem()));
    return identity;
  }
  void SetUp() override {
    const auto request = two_.request();
    ASSERT_OK(request);
    const auto reply = two_.reply(*request->message);
    ASSERT_OK(reply);
    Pairing::expect_finish_of(two_, *request, *reply);
  }
  void renew(const pki::Certificate& next) {
    second_.clock.advance(5s);
    folder_.replace("cert.pem", next.pem());
    EXPECT_THAT(second_->poll(), IsEmpty());
  }
  std::vector<Code> codes_at_the_end() {
    second_.events.all.clear();
    second_.clock.advance(15s);
    ended_ = second_->poll();
    return second_.events.codes();
  }

  const test::TemporaryFolder folder_;
  TestPlugin first_{1}, second_{2};
  Participant alice_, bob_;
  Two two_;
  std::vector<IdentityHandle> ended_;
};

TEST_F(OwnListed, RenewedCertificateOnTheList_KeepsTheSession) {
  const auto next = renewed_bob();
  folder_.write("renewed.pem", list_of({next}));
  renew(next);
  EXPECT_THAT(codes_at_the_end(), IsEmpty());
  EXPECT_THAT(ended_, IsEmpty());
  EXPECT_EQ(second_->next_expiry(), kNext.not_after);
}

TEST_F(OwnListed, RenewedCertificateThatIsNotListed_EndsTheSession) {
  folder_.write("renewed.pem", list_of({renewed_bob()}));
  renew(renewed_bob(1, {kNow + 5s, kNow + 24h}));
  EXPECT_THAT(codes_at_the_end(), ElementsAre(Code::session_outlived_documents));
}

class OwnListedForStock : public OwnListed {
 protected:
  OwnListedForStock() : OwnListed(spi::kStandardCiphers) {}
};

TEST_F(OwnListedForStock, APeerThatIsNotOfDdssec_HasNoList) {
  const auto next = renewed_bob();
  folder_.write("renewed.pem", list_of({next}));
  renew(next);
  EXPECT_THAT(codes_at_the_end(), ElementsAre(Code::session_outlived_documents));
}

// ---- a CA that is replaced

TEST(ListedOfANewCa, PeerWhoseFirstCaHasLeft_IsKept) {
  const test::TemporaryFolder folder;
  const auto old_ca = make_ca(), new_ca = make_ca();
  auto identity = make_identity(old_ca, kAlice);
  const auto both = old_ca.certificate().pem() + new_ca.certificate().pem();
  const auto put_own = [&](const Identity& own) {
    folder.replace("cert.pem", own.certificate.pem());
  };
  put_own(identity);
  folder.replace("identity_ca.pem", both);
  set(identity.properties, property::kIdentityCertificate, "file:" + folder.path() + "/cert.pem");
  set(identity.properties, property::kIdentityCa, "file:" + folder.path() + "/identity_ca.pem");
  auto bob = bob_with(kYear, 1, old_ca);
  TestPlugin first(1), second(2);
  Participant alice(first, identity, 1), peer(second, bob, 2, spi::kAllCiphers);
  Two two(alice, peer);
  const auto request = two.request();
  ASSERT_OK(request);
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  Pairing::expect_finish_of(two, *request, *reply);
  const auto poll = [&] {
    first.clock.advance(5s);
    return first->poll();
  };
  const auto own = make_identity(new_ca, kAlice, {}, {kNow, kNow + 400 * 24h});
  put_own(own);
  EXPECT_THAT(poll(), IsEmpty());
  folder.write("renewed.pem", list_of({bob_with(kNext, 1, new_ca).certificate, own.certificate}));
  first.clock.advance(5s);
  folder.replace("identity_ca.pem", new_ca.certificate().pem());
  EXPECT_THAT(poll(), IsEmpty());
  EXPECT_THAT(poll(), IsEmpty());
  folder.write("renewed.pem", "");
  const auto& all = first.events.all;
  EXPECT_TRUE(std::ranges::any_of(
      all, [](const auto& one) { return one.error.code() == Code::peer_renewal_listed; }));
}

}  // namespace
}  // namespace ddssec::authentication::listed
