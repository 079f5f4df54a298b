// Peers whose certificates end, and that stay because a renewal list has their later ones.
#include "plugins/authentication/listed_identities.hpp"

#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/listed.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication::listed {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

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
  void SetUp() override { Pairing::expect_success_of(two_); }
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

// The files are replaced one after the other, in either order.
TEST_F(OwnListed, CertificateThatIsNotTheListedOne_KeepsTheSession) {
  folder_.write("renewed.pem", list_of({renewed_bob()}));
  renew(renewed_bob(1, {kNow + 5s, kNow + 200 * 24h}));
  EXPECT_THAT(codes_at_the_end(), IsEmpty());
  EXPECT_THAT(ended_, IsEmpty());
  EXPECT_EQ(second_->next_expiry(), kNext.not_after);
}

TEST_F(OwnListed, RenewedCertificateWithoutAListedOne_EndsTheSession) {
  folder_.write("renewed.pem", list_of({make_identity(test_ca(), kAlice).certificate}));
  renew(renewed_bob());
  EXPECT_THAT(codes_at_the_end(), ElementsAre(Code::session_outlived_documents));
}

TEST_F(OwnListed, ListedCertificateOfAnotherKey_EndsTheSession) {
  folder_.write("renewed.pem", list_of({renewed_bob(2)}));
  renew(renewed_bob());
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

// Alice and Bob meet with certificates of a CA that is replaced.
class ListedOfANewCa : public testing::Test {
 protected:
  Identity with_files() {
    auto identity = make_identity(old_ca_, kAlice);
    put_own(identity);
    folder_.replace("identity_ca.pem", old_ca_.certificate().pem() + new_ca_.certificate().pem());
    set(identity.properties, property::kIdentityCertificate,
        "file:" + folder_.path() + "/cert.pem");
    set(identity.properties, property::kIdentityCa, "file:" + folder_.path() + "/identity_ca.pem");
    return identity;
  }
  void put_own(const Identity& own) { folder_.replace("cert.pem", own.certificate.pem()); }
  Identity renewed(pki::Validity validity) const {
    return make_identity(new_ca_, kAlice, {}, validity);
  }
  void SetUp() override {
    Pairing::expect_success_of(two_);
    put_own(own_);
    EXPECT_THAT(poll(), IsEmpty());
    folder_.write("renewed.pem",
                  list_of({bob_with(kNext, 1, new_ca_).certificate, own_.certificate}));
    first_.clock.advance(5s);
  }
  std::vector<IdentityHandle> poll() {
    first_.clock.advance(5s);
    return first_->poll();
  }
  void let_the_first_ca_leave() {
    folder_.replace("identity_ca.pem", new_ca_.certificate().pem());
    EXPECT_THAT(poll(), IsEmpty());
    EXPECT_THAT(poll(), IsEmpty());
    EXPECT_THAT(first_.events.codes(), Contains(Code::peer_renewal_listed));
    EXPECT_THAT(first_.events.codes(), Not(Contains(Code::identity_ca_withdrawn)));
  }

  const test::TemporaryFolder folder_;
  const pki::Authority old_ca_ = make_ca(), new_ca_ = make_ca();
  const Identity own_ = renewed({kNow, kNow + 400 * 24h});
  TestPlugin first_{1}, second_{2};
  Participant alice_{first_, with_files(), 1};
  Participant peer_{second_, bob_with(kYear, 1, old_ca_), 2, spi::kAllCiphers};
  Two two_{alice_, peer_};
};

TEST_F(ListedOfANewCa, PeerWhoseFirstCaHasLeft_IsKept) { let_the_first_ca_leave(); }

// Such as by the agent, which writes the list a moment later.
TEST_F(ListedOfANewCa, OurCertificateRenewedBeforeItsList_KeepsThePeer) {
  put_own(renewed({kNow, kNow + 401 * 24h}));
  let_the_first_ca_leave();
}

TEST_F(ListedOfANewCa, ListWithoutOurCertificate_EndsThePeerAndNamesOurs) {
  folder_.replace("renewed.pem", list_of({bob_with(kNext, 1, new_ca_).certificate}));
  folder_.replace("identity_ca.pem", new_ca_.certificate().pem());
  poll();
  EXPECT_THAT(poll(), SizeIs(1));
  const auto ended = std::ranges::find(first_.events.all, Code::identity_ca_withdrawn,
                                       [](const auto& event) { return event.error.code(); });
  ASSERT_NE(ended, first_.events.all.end());
  EXPECT_EQ(ended->error.details().field, "our CN=alice,O=Example");
  EXPECT_THAT(ended->error.details().note,
              HasSubstr("our renewal list has no valid one of ours for its key"));
  EXPECT_THAT(ended->error.details().hint, HasSubstr("ddssec crl distribute"));
}

TEST_F(ListedOfANewCa, ListWithOurNextCertificate_KeepsThePeer) {
  folder_.replace("renewed.pem", list_of({bob_with(kNext, 1, new_ca_).certificate,
                                          renewed({kNow, kNow + 401 * 24h}).certificate}));
  let_the_first_ca_leave();
}

}  // namespace
}  // namespace ddssec::authentication::listed
