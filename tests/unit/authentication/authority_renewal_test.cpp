// Identity CAs that are replaced while a participant runs.
#include <gmock/gmock.h>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication {
namespace {

using std::chrono::days;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr auto kName = "CN=Identity CA,O=Example";
constexpr pki::Validity kDecade{kNow - days(2), kNow + days(3650)};

// The two CAs have one name, as those that `ddssec ca rotate` makes.
const pki::Authority& old_ca() {
  static const auto ca = make_ca(kName, {}, kDecade);
  return ca;
}
const pki::Authority& new_ca() {
  static const auto ca = make_ca(kName, {}, kDecade);
  return ca;
}
const pki::Authority& third_ca() {
  static const auto ca = make_ca(kName, {}, kDecade);
  return ca;
}

std::string bundle(std::initializer_list<const pki::Authority*> cas) {
  std::string out;
  for (const auto* ca : cas) out += ca->certificate().pem();
  return out;
}

Identity trusting_all(Identity identity) {
  set(identity.properties, property::kIdentityCa,
      "data:," + bundle({&old_ca(), &new_ca(), &third_ca()}));
  return identity;
}

Identity alice_of(const pki::Authority& ca, pki::Validity validity = kYear, int key = 0) {
  return make_identity(ca, "CN=alice,O=Example", {}, validity, key);
}
Identity bob_of(const pki::Authority& ca) {
  return trusting_all(make_identity(ca, "CN=bob,O=Example", {}, kYear, 1));
}

// Alice has files and a certificate of the old CA. Bob, whose certificate is of the old CA too,
// trusts both CAs.
class IdentityCaRenewal : public testing::Test {
 protected:
  IdentityCaRenewal() : pairing_(alice(), bob_of(old_ca())) {}

  Identity alice() {
    auto identity = alice_of(old_ca());
    set(identity.properties, property::kIdentityCertificate,
        "file:" + folder_.write("cert.pem", identity.certificate.pem()));
    set(identity.properties, property::kPrivateKey,
        "file:" + folder_.write("key.pem", pem_text(identity.key)));
    path_ = folder_.write("identity_ca.pem", bundle({&old_ca()}));
    set(identity.properties, property::kIdentityCa, "file:" + path_);
    return identity;
  }
  void put(std::initializer_list<const pki::Authority*> cas) {
    folder_.replace("identity_ca.pem", bundle(cas));
  }
  std::vector<IdentityHandle> poll() { return plugin().poll(); }
  std::vector<Code> codes_after_looking() { return plugin().codes_after_looking(); }
  void expect_refused(std::string_view why) {
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewal_refused));
    ASSERT_FALSE(events().empty());
    EXPECT_EQ(events().front().error.details().document, path_);
    EXPECT_THAT(events().front().error.to_sentence(), HasSubstr(why));
    EXPECT_THAT(events().front().error.to_sentence(), HasSubstr("read before stay in force"));
    EXPECT_THAT(codes_after_looking(), IsEmpty()) << "told twice";
  }
  // True if a participant that has not met Alice authenticates with her.
  bool meets(const pki::Authority& ca) {
    TestPlugin other{7};
    Participant carol(other, trusting_all(make_identity(ca, "CN=carol,O=Example", {}, kYear, 2)),
                      ++carols_);
    Two two(pairing_.a, carol);
    return Pairing::authenticate(two);
  }
  TestPlugin& plugin() { return pairing_.first_plugin; }
  std::vector<Event>& events() { return plugin().events.all; }
  IdentityHandle bob_at_alice() {
    return &pairing_.two.low == &pairing_.a ? pairing_.two.high_at_low : pairing_.two.low_at_high;
  }

  const test::TemporaryFolder folder_;
  std::string path_;
  Pairing pairing_;
  std::uint8_t carols_ = 10;
};

// ---- overlap

TEST_F(IdentityCaRenewal, SecondCa_IsAcceptedBesideTheFirst) {
  EXPECT_TRUE(meets(old_ca()));
  EXPECT_FALSE(meets(new_ca()));
  put({&old_ca(), &new_ca()});
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
  const auto& event = events().front();
  EXPECT_EQ(event.severity, Severity::informational);
  EXPECT_EQ(event.guid, pairing_.a.guid.to_string());
  EXPECT_EQ(event.error.details().document, path_);
  EXPECT_THAT(event.error.details().found, HasSubstr(kName));
  EXPECT_TRUE(meets(old_ca()));
  EXPECT_TRUE(meets(new_ca()));
  EXPECT_FALSE(meets(third_ca()));
}

TEST_F(IdentityCaRenewal, OtherOrder_IsNoEvent) {
  put({&new_ca(), &old_ca()});
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
  put({&old_ca(), &new_ca()});
  EXPECT_THAT(codes_after_looking(), IsEmpty());
}

TEST_F(IdentityCaRenewal, SecondCa_LeavesSessionsAlone) {
  pairing_.expect_success();
  put({&new_ca(), &old_ca()});
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
  EXPECT_THAT(plugin().ended, IsEmpty());
}

TEST_F(IdentityCaRenewal, CertificateOfTheSecondCa_IsTakenWithIt) {
  put({&new_ca(), &old_ca()});
  folder_.replace("cert.pem", alice_of(new_ca(), {kNow, kYear.not_after}).certificate.pem());
  EXPECT_THAT(codes_after_looking(),
              ElementsAre(Code::identity_ca_renewed, Code::identity_renewed));
  pairing_.expect_success();
}

// ---- relative paths

// Alice's properties have relative paths, and the process has changed its working directory after
// it read them.
struct RelativeIdentityPaths : testing::Test {
  RelativeIdentityPaths() {
    write_all(folder, {&old_ca()}, alice.certificate);
    set(alice.properties, property::kIdentityCa, "file:identity_ca.pem");
    set(alice.properties, property::kIdentityCertificate, "file:cert.pem");
    set(alice.properties, property::kPrivateKey, "file:key.pem");
    const test::WorkingFolder at(folder.path());
    EXPECT_TRUE(plugin->validate_local_identity(0, alice.properties, candidate(1)));
  }
  void write_all(const test::TemporaryFolder& where,
                 std::initializer_list<const pki::Authority*> cas,
                 const pki::Certificate& certificate) {
    where.replace("identity_ca.pem", bundle(cas));
    where.replace("cert.pem", certificate.pem());
    where.replace("key.pem", pem_text(alice.key));
  }
  // Returns the events after several looks, each with the place of the file that it is about.
  std::vector<std::pair<Code, std::string>> told() {
    plugin.events.all.clear();
    for (int i = 0; i < 3; ++i) {
      plugin.clock.advance(5s);
      EXPECT_THAT(plugin->poll(), IsEmpty());
    }
    std::vector<std::pair<Code, std::string>> out;
    for (const auto& event : plugin.events.all)
      out.emplace_back(event.error.code(), event.error.details().document);
    return out;
  }
  const test::TemporaryFolder folder, elsewhere;
  const pki::Certificate renewed = alice_of(old_ca(), {kNow, kYear.not_after}).certificate;
  Identity alice = alice_of(old_ca());
  TestPlugin plugin;
  const test::WorkingFolder there{elsewhere.path()};
};

TEST_F(RelativeIdentityPaths, FilesInTheNextWorkingDirectory_AreNotTaken) {
  told();
  write_all(elsewhere, {&old_ca(), &third_ca()}, renewed);
  elsewhere.replace("crl.pem", pem({9, {alice.certificate}}, old_ca()));
  EXPECT_THAT(told(), IsEmpty());
}

TEST_F(RelativeIdentityPaths, FilesWhereTheyWereAtTheStart_AreFollowed) {
  told();
  write_all(folder, {&old_ca(), &new_ca()}, renewed);
  const auto in = [&](const std::string& name) { return folder.path() + "/" + name; };
  EXPECT_THAT(told(), ElementsAre(std::pair(Code::identity_ca_renewed, in("identity_ca.pem")),
                                  std::pair(Code::identity_renewed, in("cert.pem"))));
  write_all(folder, {&old_ca()}, renewed);
  told();
  folder.replace("crl.pem", pem({9}, old_ca()));
  EXPECT_THAT(told(), ElementsAre(std::pair(Code::crl_renewed, in("crl.pem"))));
}

// ---- the old CA leaves

TEST_F(IdentityCaRenewal, CaThatLeaves_EndsItsPeers) {
  pairing_.expect_success();
  put({&new_ca(), &old_ca()});
  folder_.replace("cert.pem", alice_of(new_ca(), {kNow, kYear.not_after}).certificate.pem());
  codes_after_looking();
  put({&new_ca()});
  events().clear();
  EXPECT_THAT(poll(), IsEmpty()) << "the file may not be whole";
  EXPECT_THAT(poll(), ElementsAre(bob_at_alice()));
  ASSERT_EQ(events().size(), 2u);
  EXPECT_EQ(events().front().error.code(), Code::identity_ca_renewed);
  const auto& event = events().back();
  EXPECT_EQ(event.error.code(), Code::identity_ca_withdrawn);
  EXPECT_EQ(event.peer_subject, "CN=bob,O=Example");
  EXPECT_EQ(event.proof, PeerProof::authenticated);
  EXPECT_EQ(event.error.details().document, path_);
  EXPECT_EQ(event.error.details().field, "CN=bob,O=Example");
  EXPECT_THAT(poll(), IsEmpty()) << "ended twice";
  EXPECT_FALSE(meets(old_ca()));
  EXPECT_TRUE(meets(new_ca()));
}

TEST_F(IdentityCaRenewal, CaThatLeaves_LeavesPeersOfTheOtherAlone) {
  TestPlugin other{7};
  Participant carol(other,
                    trusting_all(make_identity(new_ca(), "CN=carol,O=Example", {}, kYear, 2)), 30);
  put({&new_ca(), &old_ca()});
  codes_after_looking();
  Two two(pairing_.a, carol);
  const auto request = two.request();
  ASSERT_OK(request);
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  Pairing::expect_finish_of(two, *request, *reply);
  folder_.replace("cert.pem", alice_of(new_ca(), {kNow, kYear.not_after}).certificate.pem());
  put({&new_ca()});
  EXPECT_THAT(codes_after_looking(),
              ElementsAre(Code::identity_renewed, Code::identity_ca_renewed));
  EXPECT_THAT(plugin().ended, IsEmpty());
}

TEST_F(IdentityCaRenewal, HandshakeThatBeganUnderTheOldCa_DoesNotEndUnderTheNew) {
  put({&new_ca(), &old_ca()});
  folder_.replace("cert.pem", alice_of(new_ca(), {kNow, kYear.not_after}).certificate.pem());
  codes_after_looking();
  const auto request = pairing_.two.request();
  ASSERT_OK(request);
  const auto reply = pairing_.two.reply(*request->message);
  ASSERT_OK(reply);
  put({&new_ca()});
  poll();
  poll();
  const auto final_message = pairing_.two.process_at_lower_guid(request->handle, *reply->message);
  if (&pairing_.two.low == &pairing_.a) {
    EXPECT_CODE(final_message, issuer_unknown);
    return;
  }
  ASSERT_OK(final_message);
  EXPECT_CODE(pairing_.two.process_at_higher_guid(reply->handle, *final_message->message),
              issuer_unknown);
}

TEST_F(IdentityCaRenewal, CaWithoutOverlap_IsTakenTogetherWithOurCertificate) {
  pairing_.expect_success();
  put({&new_ca()});
  folder_.replace("cert.pem", alice_of(new_ca(), {kNow, kYear.not_after}).certificate.pem());
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed, Code::identity_renewed,
                                                 Code::identity_ca_withdrawn));
  EXPECT_FALSE(meets(old_ca()));
  EXPECT_TRUE(meets(new_ca()));
}

TEST_F(IdentityCaRenewal, CertificateThatComesOneLookLater_IsNoRefusal) {
  put({&new_ca()});
  poll();
  folder_.replace("cert.pem", alice_of(new_ca(), {kNow, kYear.not_after}).certificate.pem());
  EXPECT_THAT(codes_after_looking(),
              ElementsAre(Code::identity_ca_renewed, Code::identity_renewed));
}

// ---- with revocation lists

TEST_F(IdentityCaRenewal, RevocationList_IsTakenTogetherWithItsCa) {
  auto identity = alice();
  folder_.write("crl.pem", pem({.number = 4}, old_ca()));
  TestPlugin other{3};
  Participant alone(other, identity, 9);
  const auto next = alice_of(new_ca(), {kNow, kYear.not_after});
  folder_.replace("crl.pem", pem({.number = 1}, new_ca()));
  folder_.replace("cert.pem", next.certificate.pem());
  put({&new_ca()});
  other.events.all.clear();
  for (int i = 0; i < 3; ++i) {
    other.clock.advance(5s);
    EXPECT_THAT(other->poll(), IsEmpty());
  }
  std::vector<Code> codes;
  for (const auto& event : other.events.all) codes.push_back(event.error.code());
  EXPECT_THAT(codes, ElementsAre(Code::identity_ca_renewed, Code::identity_renewed));
  folder_.replace("crl.pem", pem({2, {next.certificate}}, new_ca()));
  other.clock.advance(5s);
  EXPECT_THAT(other->poll(), ElementsAre(alone.handle)) << "later lists do not count";
}

TEST_F(IdentityCaRenewal, ListsOfBothCas_CountDuringTheOverlap) {
  auto identity = alice();
  folder_.write("crl.pem", pem({.number = 4}, old_ca()));
  TestPlugin other{3};
  Participant alone(other, identity, 9);
  folder_.replace("crl.pem", pem({.number = 4}, old_ca()) + pem({.number = 1}, new_ca()));
  put({&old_ca(), &new_ca()});
  for (int i = 0; i < 3; ++i) {
    other.clock.advance(5s);
    EXPECT_THAT(other->poll(), IsEmpty());
  }
  folder_.replace("crl.pem", pem({5, {identity.certificate}}, old_ca()) + pem({}, new_ca()));
  other.clock.advance(5s);
  EXPECT_THAT(other->poll(), ElementsAre(alone.handle));
}

// ---- what is refused

TEST_F(IdentityCaRenewal, FileWithoutOurCa_IsRefused) {
  put({&new_ca()});
  expect_refused("no configured CA issued the certificate");
  EXPECT_TRUE(meets(old_ca()));
  EXPECT_FALSE(meets(new_ca()));
}

TEST_F(IdentityCaRenewal, CertificateThatIsNoCa_IsRefused) {
  folder_.replace("identity_ca.pem", bundle({&old_ca()}) + alice_of(old_ca()).certificate.pem());
  expect_refused("used as a CA");
}

TEST_F(IdentityCaRenewal, CaThatWasWithdrawn_IsRefusedAsARollBack) {
  put({&new_ca(), &old_ca()});
  folder_.replace("cert.pem", alice_of(new_ca(), {kNow, kYear.not_after}).certificate.pem());
  codes_after_looking();
  put({&new_ca()});
  codes_after_looking();
  put({&new_ca(), &old_ca()});
  expect_refused("has left the CA file");
  EXPECT_FALSE(meets(old_ca()));
  put({&new_ca(), &third_ca()});
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
}

TEST_F(IdentityCaRenewal, CertificateOfTheWithdrawnCa_IsRefusedAsARollBack) {
  const auto former = alice_of(old_ca(), {kNow, kYear.not_after});
  put({&new_ca()});
  folder_.replace("cert.pem", alice_of(new_ca(), {kNow, kYear.not_after}).certificate.pem());
  codes_after_looking();
  folder_.replace("cert.pem", former.certificate.pem());
  put({&old_ca()});
  EXPECT_THAT(codes_after_looking(),
              testing::UnorderedElementsAre(Code::identity_ca_renewal_refused,
                                            Code::identity_renewal_refused));
  EXPECT_FALSE(meets(old_ca()));
}

TEST_F(IdentityCaRenewal, WhatIsNoFileOfCas_IsReportedOnceAndNothingIsLost) {
  for (const auto& text : {std::string(), std::string("nonsense"),
                           bundle({&old_ca()}).substr(0, 200), std::string(2'000'000, 'x')}) {
    folder_.replace("identity_ca.pem", text);
    EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewal_refused));
    EXPECT_THAT(codes_after_looking(), IsEmpty());
  }
  std::filesystem::remove(path_);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewal_refused));
  std::filesystem::create_directory(path_);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewal_refused));
  EXPECT_TRUE(meets(old_ca()));
  pairing_.expect_success();
}

TEST_F(IdentityCaRenewal, FileThatIsJustBeingWritten_IsNoEvent) {
  const auto both = bundle({&old_ca(), &new_ca()});
  folder_.write("identity_ca.pem", both.substr(0, both.size() - 200));
  poll();
  folder_.write("identity_ca.pem", both);
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
}

// The writer stops after the first of two certificates.
TEST_F(IdentityCaRenewal, FileCutBetweenItsCertificates_LosesNoCa) {
  put({&old_ca(), &new_ca()});
  codes_after_looking();
  folder_.write("identity_ca.pem", bundle({&old_ca()}));
  poll();
  EXPECT_TRUE(meets(new_ca()));
  folder_.write("identity_ca.pem", bundle({&old_ca(), &new_ca()}));
  EXPECT_THAT(codes_after_looking(), IsEmpty());
  EXPECT_TRUE(meets(new_ca()));
}

TEST_F(IdentityCaRenewal, FileThatKeepsChanging_CostsOneLookForEachInterval) {
  events().clear();
  for (int i = 0; i < 50; ++i) {
    folder_.replace("identity_ca.pem", "nonsense " + std::to_string(i));
    plugin().clock.advance(100ms);
    plugin()->poll();
  }
  EXPECT_THAT(events(), testing::SizeIs(testing::AllOf(testing::Ge(2u), testing::Le(5u))));
}

TEST_F(IdentityCaRenewal, CasThatComeAndGo_AreBounded) {
  const auto ca = [](int i) { return make_ca("CN=" + std::to_string(i), {}, kDecade); };
  int taken = 0;
  for (int i = 0; i < 300; ++i) {
    const auto other = ca(i);
    put({&old_ca(), &other});
    events().clear();
    poll();
    poll();
    if (!events().empty() && events().front().error.code() == Code::identity_ca_renewed) ++taken;
  }
  EXPECT_EQ(taken, 257);
  EXPECT_TRUE(meets(old_ca()));
}

TEST_F(IdentityCaRenewal, CaThatIsNotValidYet_DoesNotDisturbOurs) {
  const auto later = make_ca(kName, {}, {kNow + days(1), kNow + days(900)});
  put({&later, &old_ca()});
  EXPECT_THAT(codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
  EXPECT_TRUE(meets(old_ca()));
}

TEST_F(IdentityCaRenewal, ClockThatGoesBackAndForth_ChangesNothing) {
  put({&old_ca(), &new_ca()});
  codes_after_looking();
  plugin().clock.advance(days(-300));
  codes_after_looking();
  plugin().clock.advance(days(300));
  codes_after_looking();
  EXPECT_TRUE(meets(new_ca()));
}

TEST_F(IdentityCaRenewal, IntervalOfZero_MeansNever) {
  auto identity = alice();
  set(identity.properties, property::kFilesPollInterval, "0");
  TestPlugin other{3};
  Participant alone(other, identity, 9);
  other.events.all.clear();
  put({&old_ca(), &new_ca()});
  other.clock.advance(60s);
  other->poll();
  EXPECT_THAT(other.events.all, IsEmpty());
}

TEST_F(IdentityCaRenewal, FolderOfTrustedCas_MustHaveEveryCa) {
  auto identity = alice();
  const test::TemporaryFolder trusted;
  trusted.write("old.pem", bundle({&old_ca()}));
  set(identity.properties, property::kTrustedCaDir, "file:" + trusted.path());
  TestPlugin other{3};
  Participant alone(other, identity, 9);
  other.events.all.clear();
  put({&old_ca(), &new_ca()});
  for (int i = 0; i < 3; ++i) {
    other.clock.advance(5s);
    other->poll();
  }
  ASSERT_EQ(other.events.all.size(), 1u);
  EXPECT_EQ(other.events.all.front().error.code(), Code::identity_ca_renewal_refused);
  EXPECT_THAT(other.events.all.front().error.to_sentence(), HasSubstr("not among the trusted"));
}

// ---- ends

// `ddssec ca renew` makes a certificate with the same name and key, and a later end.
TEST(AuthorityRenewalOfOneKey, CaThatLivesLonger_MovesTheEndOfSessions) {
  const test::TemporaryFolder folder;
  const auto ca = make_ca(kName, {}, {kNow - days(2), kNow + days(30)});
  const auto longer = ca.renewed(kDecade, test_random()).value();
  auto alice = alice_of(ca, kYear);
  set(alice.properties, property::kIdentityCa,
      "file:" + folder.write("identity_ca.pem", ca.certificate().pem()));
  Pairing pairing(alice, make_identity(ca, "CN=bob,O=Example", {}, kYear, 1));
  pairing.expect_success();
  auto& plugin = pairing.first_plugin;
  EXPECT_EQ(plugin->next_expiry(), kNow + days(30));
  folder.replace("identity_ca.pem", longer.pem());
  EXPECT_THAT(plugin.codes_after_looking(), ElementsAre(Code::identity_ca_renewed));
  EXPECT_EQ(plugin->next_expiry(), kYear.not_after);
  plugin.clock.advance(days(31));
  EXPECT_THAT(plugin->poll(), IsEmpty());
}

}  // namespace
}  // namespace ddssec::authentication
