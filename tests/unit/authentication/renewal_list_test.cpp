// Peers whose certificates end, and who stay because a renewal list has their later ones.
#include "pki/renewal_list.hpp"

#include <cstring>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <gmock/gmock.h>

#include "tests/support/recorded_document.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr auto kAlice = "CN=alice,O=Example";
constexpr auto kBob = "CN=bob,O=Example";
constexpr pki::Validity kShort{kNow - 24h, kNow + 20s};
constexpr pki::Validity kNext{kNow + 5s, kNow + 100 * 24h};

/// Bob's key has index 1.
Identity bob_with(pki::Validity validity, int key = 1, const pki::Authority& ca = test_ca(),
                  const std::string& subject = kBob) {
  return make_identity(ca, subject, {}, validity, key);
}
pki::Certificate renewed_bob(int key = 1, pki::Validity validity = kNext) {
  return bob_with(validity, key).certificate;
}
std::string list_of(std::vector<pki::Certificate> certificates) {
  return pki::RenewalList{.certificates = std::move(certificates)}.text().value();
}

/// Alice has files; Bob has a certificate that ends 20 seconds from now.
class Listed : public testing::Test {
 protected:
  explicit Listed(const std::string& crl = {}) : pairing_(with_files(crl), bob_) {}

  void SetUp() override {
    pairing_.expect_success();
    events().clear();
  }

  Identity with_files(const std::string& crl) const {
    auto identity = make_identity(test_ca(), kAlice);
    set(identity.properties, property::kIdentityCertificate,
        "file:" + folder_.write("cert.pem", identity.certificate.pem()));
    if (!crl.empty()) folder_.write("crl.pem", crl);
    return identity;
  }
  void put(const std::string& text) { folder_.replace("renewed.pem", text); }
  std::vector<IdentityHandle> look(std::chrono::seconds after = 5s) {
    engine().clock.advance(after);
    return engine()->expire();
  }
  /// Until a minute after the end of Bob's certificate; who ended.
  std::vector<IdentityHandle> pass_the_end() {
    std::vector<IdentityHandle> ended;
    for (int i = 0; i < 16; ++i)
      for (const auto handle : look()) ended.push_back(handle);
    return ended;
  }
  std::vector<Code> codes() {
    std::vector<Code> out;
    for (const auto& event : events()) out.push_back(event.error.code());
    events().clear();
    return out;
  }
  void expect_ends(std::string_view note) {
    EXPECT_THAT(pass_the_end(), ElementsAre(bob_at_alice()));
    ASSERT_FALSE(events().empty());
    const auto& error = events().back().error;
    EXPECT_EQ(error.code(), Code::identity_ended);
    EXPECT_EQ(events().back().peer_subject, kBob);
    EXPECT_THAT(error.details().note, HasSubstr(note));
  }
  Engine& engine() { return pairing_.first_engine; }
  std::vector<Event>& events() { return engine().events.events; }
  IdentityHandle bob_at_alice() {
    return &pairing_.two.low == &pairing_.a ? pairing_.two.high_at_low : pairing_.two.low_at_high;
  }
  std::string path() const { return folder_.path() + "/renewed.pem"; }

  const test::TemporaryFolder folder_;
  const Identity bob_ = bob_with(kShort);
  Pairing pairing_;
};

// ---- what keeps a peer

TEST_F(Listed, CertificateOfTheSameKey_KeepsThePeer) {
  put(list_of({renewed_bob()}));
  EXPECT_THAT(look(), IsEmpty());
  ASSERT_THAT(codes(), ElementsAre(Code::renewal_list_taken));
  EXPECT_EQ(engine()->next_expiry(), kShort.not_after);
  EXPECT_THAT(pass_the_end(), IsEmpty());
  ASSERT_EQ(events().size(), 1u);
  const auto& event = events().front();
  EXPECT_EQ(event.error.code(), Code::peer_renewal_listed);
  EXPECT_EQ(event.severity, Severity::informational);
  EXPECT_EQ(event.peer_subject, kBob);
  EXPECT_EQ(event.guid, pairing_.b.guid.to_string());
  EXPECT_EQ(event.error.details().found, to_string(kNext.not_after));
  EXPECT_EQ(engine()->next_expiry(), kNext.not_after);
}

TEST_F(Listed, ThePeerThatIsKept_EndsWithItsLaterCertificate) {
  put(list_of({renewed_bob(1, {kNow + 5s, kNow + 40s})}));
  look();
  EXPECT_THAT(look(16s), IsEmpty());
  EXPECT_THAT(look(18s), IsEmpty());
  EXPECT_THAT(look(1s), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_taken, Code::peer_renewal_listed,
                                   Code::identity_ended));
}

TEST_F(Listed, ASecondRenewal_KeepsThePeerAgain) {
  put(list_of({renewed_bob(1, {kNow + 5s, kNow + 40s})}));
  look(21s);
  put(list_of({renewed_bob(1, {kNow + 30s, kNow + 24h})}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_EQ(engine()->next_expiry(), kNow + 24h);
}

TEST_F(Listed, TheOneThatEndsLast_Counts) {
  put(list_of({renewed_bob(1, {kNow + 5s, kNow + 40s}), renewed_bob(),
               renewed_bob(1, {kNow + 6s, kNow + 41s})}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_EQ(engine()->next_expiry(), kNext.not_after);
}

TEST_F(Listed, AListOfTheLastSecond_Counts) {
  look(19s);
  put(list_of({renewed_bob()}));
  EXPECT_THAT(look(1s), IsEmpty());
  EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_taken, Code::peer_renewal_listed));
}

// ---- what does not

TEST_F(Listed, WithoutAList_ThePeerEndsInTime) {
  EXPECT_THAT(look(19s), IsEmpty());
  EXPECT_THAT(look(1s), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), ElementsAre(Code::identity_ended));
}

TEST_F(Listed, AnotherKey_IsNotProven) {
  put(list_of({renewed_bob(7)}));
  expect_ends("another key");
}

TEST_F(Listed, AnotherKindOfKey_IsNotProven) {
  const auto p384 = make_identity(test_ca(), kBob, {KeyKind::ec_p384, 384}, kNext);
  put(list_of({p384.certificate}));
  expect_ends("another key");
}

TEST_F(Listed, AnotherSubjectWithTheKey_HelpsNotAtAll) {
  put(list_of({bob_with(kNext, 1, test_ca(), "CN=bobby,O=Example").certificate}));
  expect_ends("");
}

TEST_F(Listed, ACertificateThatBeginsEarlier_IsAReplay) {
  put(list_of({renewed_bob(1, {kNow - 48h, kNow + 24h})}));
  expect_ends("begins before");
}

TEST_F(Listed, ACertificateThatBeginsInTheFuture_DoesNotCountYet) {
  put(list_of({renewed_bob(1, {kNow + 1h, kNow + 24h})}));
  expect_ends("not valid yet");
}

TEST_F(Listed, AListThatComesAfterTheEnd_BringsNoOneBack) {
  look(20s);
  put(list_of({renewed_bob()}));
  look();
  EXPECT_THAT(codes(), ElementsAre(Code::identity_ended, Code::renewal_list_taken));
  EXPECT_CODE(pairing_.a.discover(pairing_.b), identity_ended);
}

// ---- revocation

class ListedWithCrl : public Listed {
 protected:
  ListedWithCrl() : Listed(pem({})) {}
  void revoke(std::vector<pki::Certificate> certificates, std::uint64_t number = 2) {
    folder_.replace("crl.pem", pem({.number = number, .revoked = std::move(certificates)}));
  }
};

TEST_F(ListedWithCrl, ARevokedLaterCertificate_DoesNotCount) {
  const auto later = renewed_bob();
  revoke({later});
  put(list_of({later, renewed_bob(7)}));
  expect_ends("another key");
}

TEST_F(ListedWithCrl, ARevokedOneAlone_IsARefusedList) {
  const auto later = renewed_bob();
  revoke({later});
  put(list_of({later}));
  EXPECT_THAT(pass_the_end(), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), Contains(Code::renewal_list_refused));
}

TEST_F(ListedWithCrl, ARevocationAfterTheList_CountsAtOnce) {
  const auto later = renewed_bob();
  put(list_of({later}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  codes();
  revoke({later});
  EXPECT_THAT(pass_the_end(), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), Contains(Code::certificate_revoked));
}

TEST_F(ListedWithCrl, ARevocationOfTheFirstCertificate_EndsAPeerThatIsKept) {
  put(list_of({renewed_bob()}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  revoke({bob_.certificate});
  EXPECT_THAT(pass_the_end(), ElementsAre(bob_at_alice()));
  EXPECT_THAT(codes(), Contains(Code::certificate_revoked));
}

// The list was made before the revocation, and is put back after it.
TEST_F(ListedWithCrl, AReplayedList_BringsNoRevokedPeerBack) {
  const auto later = renewed_bob();
  revoke({later, bob_.certificate});
  EXPECT_THAT(look(), ElementsAre(bob_at_alice()));
  put(list_of({later}));
  EXPECT_THAT(pass_the_end(), IsEmpty());
  EXPECT_CODE(pairing_.a.discover(pairing_.b), certificate_revoked);
}

// ---- a list that cannot be used

class BadList : public Listed {
 protected:
  void SetUp() override {
    Listed::SetUp();
    put(list_of({renewed_bob()}));
    look();
    EXPECT_THAT(codes(), ElementsAre(Code::renewal_list_taken));
  }
  /// It changes nothing, and one event says what is wrong.
  void expect_refused(std::string_view why) {
    EXPECT_THAT(pass_the_end(), IsEmpty());
    std::vector<Event> refusals;
    for (const auto& event : events())
      if (event.error.code() == Code::renewal_list_refused) refusals.push_back(event);
    ASSERT_EQ(refusals.size(), 1u);
    const auto& error = refusals.front().error;
    EXPECT_EQ(error.details().document, path());
    EXPECT_THAT(error.to_sentence(), HasSubstr(why));
    EXPECT_THAT(error.to_sentence(), HasSubstr("the list read before stays in force"));
    EXPECT_THAT(codes(), Contains(Code::peer_renewal_listed));
  }
  void remove() { ::unlink(path().c_str()); }
};

TEST_F(BadList, Garbage) {
  put("garbage");
  expect_refused("at least one entry");
}
TEST_F(BadList, Empty) {
  put("");
  expect_refused("empty");
}
TEST_F(BadList, Missing) {
  remove();
  expect_refused("");
}
TEST_F(BadList, AFolder) {
  remove();
  ::mkdir(path().c_str(), 0700);
  expect_refused("");
}
TEST_F(BadList, ASocket) {
  remove();
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{.sun_family = AF_UNIX, .sun_path = {}};
  std::strncpy(address.sun_path, path().c_str(), sizeof address.sun_path - 1);
  ASSERT_EQ(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  expect_refused("");
  ::close(socket);
}
TEST_F(BadList, CutShort) {
  const auto text = list_of({renewed_bob(), bob_.certificate});
  put(text.substr(0, text.size() - 100));
  expect_refused("cut short");
}
TEST_F(BadList, ABlockThatDoesNotBelongThere) {
  put(list_of({renewed_bob()}) + pem_text(bob_.key));
  expect_refused("a block PRIVATE KEY");
}
TEST_F(BadList, Gigabytes) {
  remove();
  put("");
  ASSERT_EQ(::truncate(path().c_str(), off_t{4} << 30), 0);
  expect_refused("");
}
TEST_F(BadList, ThousandsOfEntries) {
  std::string text;
  for (std::size_t i = 0; i <= pki::kMaxRenewals; ++i) text += bob_.certificate.pem();
  put(text);
  expect_refused("at most 1024 certificates");
}
TEST_F(BadList, AnotherCa) {
  const auto other = make_ca("CN=Other CA,O=Example");
  put(list_of({bob_with(kNext, 1, other).certificate}));
  expect_refused("CN=Identity CA,O=Example");
}
// With a CA of the same name.
TEST_F(BadList, ACaOfTheSameName) {
  const auto other = make_ca();
  put(list_of({bob_with(kNext, 1, other).certificate}));
  expect_refused("");
}

TEST_F(Listed, EntriesOfAnotherCa_AreCountedAndPassedOver) {
  const auto other = make_ca("CN=Other CA,O=Example");
  put(list_of({bob_with(kNext, 1, other).certificate, renewed_bob()}));
  look();
  ASSERT_EQ(events().size(), 1u);
  EXPECT_THAT(events().front().error.details().note, HasSubstr("1 more certificates do not count"));
  EXPECT_THAT(pass_the_end(), IsEmpty());
}

TEST_F(Listed, TheRecord_HasTheListAndWhatWasRefused) {
  put(list_of({renewed_bob()}));
  look();
  const auto taken = engine().documents.to_json();
  EXPECT_THAT(taken, HasSubstr("renewal list"));
  EXPECT_THAT(taken, HasSubstr(path()));
  put("garbage");
  look();
  look();
  EXPECT_THAT(engine().documents.to_json(), HasSubstr("renewal_list_refused"));
}

// ---- the place

TEST(ListedPlace, OfTheProperty_IsReadInsteadOfTheUsualOne) {
  const test::TemporaryFolder folder;
  auto identity = make_identity(test_ca(), kAlice);
  set(identity.properties, property::kRenewalList,
      "file:" + folder.write("list.pem", list_of({renewed_bob()})));
  Pairing pairing(identity, bob_with(kShort));
  pairing.expect_success();
  pairing.first_engine.clock.advance(20s);
  EXPECT_THAT(pairing.first_engine->expire(), IsEmpty());
}

TEST(ListedPlace, ThatIsNoFile_IsRefused) {
  auto identity = make_identity(test_ca(), kAlice);
  set(identity.properties, property::kRenewalList, "data:,x");
  Engine engine;
  EXPECT_CODE(engine->validate_local_identity(0, identity.properties, candidate(1)),
              invalid_property);
}

// ---- our own certificate, which a peer has seen

/// Bob has files; his certificate ends, and is renewed in time.
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
    EXPECT_THAT(second_->expire(), IsEmpty());
  }
  std::vector<Code> codes_at_the_end() {
    second_.events.events.clear();
    second_.clock.advance(15s);
    ended_ = second_->expire();
    std::vector<Code> out;
    for (const auto& event : second_.events.events) out.push_back(event.error.code());
    return out;
  }

  const test::TemporaryFolder folder_;
  Engine first_{1}, second_{2};
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

TEST(ListedOfANewCa, KeepsAPeerWhoseFirstCaHasLeft) {
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
  Engine first(1), second(2);
  Participant alice(first, identity, 1), peer(second, bob, 2, spi::kAllCiphers);
  Two two(alice, peer);
  const auto request = two.request();
  ASSERT_OK(request);
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  Pairing::expect_finish_of(two, *request, *reply);
  const auto look = [&] {
    first.clock.advance(5s);
    return first->expire();
  };
  const auto own = make_identity(new_ca, kAlice, {}, {kNow, kNow + 400 * 24h});
  put_own(own);
  EXPECT_THAT(look(), IsEmpty());
  folder.write("renewed.pem", list_of({bob_with(kNext, 1, new_ca).certificate, own.certificate}));
  first.clock.advance(5s);
  folder.replace("identity_ca.pem", new_ca.certificate().pem());
  EXPECT_THAT(look(), IsEmpty());
  EXPECT_THAT(look(), IsEmpty());
  folder.write("renewed.pem", "");
  const auto& all = first.events.events;
  EXPECT_TRUE(std::ranges::any_of(
      all, [](const auto& one) { return one.error.code() == Code::peer_renewal_listed; }));
}

}  // namespace
}  // namespace ddssec::authentication
