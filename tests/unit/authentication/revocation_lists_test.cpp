// The places where a revocation list is looked for, and how often.
#include "plugins/authentication/revocation_lists.hpp"

#include <gmock/gmock.h>

#include "tests/support/recorded_document.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/authentication/revocation_lists.hpp"

namespace ddssec::authentication {
namespace {

// ---- properties

struct Watcher {
  Watcher(const test::TemporaryFolder& folder, std::string_view name, const std::string& interval)
      : identity(with_list(alice(), "file:" + folder.path() + "/crl.pem", name)) {
    set(identity.properties, property::kFilesPollInterval, interval);
  }
  // Returns how long after Alice's list appeared her identity ended, if it ended within a minute.
  std::optional<std::chrono::seconds> ends_after(const test::TemporaryFolder& folder) {
    Participant us(plugin, identity);
    for (int i = 0; i < 30; ++i) poll();
    folder.replace("crl.pem", pem({9, {alice().certificate}}));
    for (int i = 1; i < 60; ++i)
      if (poll()) return std::chrono::seconds(i);
    return std::nullopt;
  }
  bool poll() {
    plugin.clock.advance(1s);
    return !plugin->poll().empty();
  }
  Identity identity;
  TestPlugin plugin;
};

TEST(PollInterval, Property_SaysHowOftenToLook) {
  const test::TemporaryFolder folder;
  const auto ends_after = [&](const std::string& interval) {
    folder.replace("crl.pem", pem({}));
    return Watcher(folder, property::kCrl, interval).ends_after(folder);
  };
  EXPECT_LE(ends_after("5").value(), 5s);
  EXPECT_EQ(ends_after("1").value(), 1s);
  EXPECT_LE(ends_after("20").value(), 20s);
  EXPECT_GT(ends_after("20").value(), 1s);
  EXPECT_FALSE(ends_after("0"));
}

TEST(PollInterval, OtherThanSeconds_IsRefused) {
  auto identity = alice();
  set(identity.properties, property::kFilesPollInterval, "5s");
  TestPlugin plugin;
  const auto result = plugin->validate_local_identity(0, identity.properties, candidate(1));
  EXPECT_CODE(result, invalid_property);
}

TEST(LaterCrl, ListThatComesLater_IsTaken) {
  const test::TemporaryFolder folder;
  Watcher watcher(folder, property::kLaterCrl, "1");
  EXPECT_EQ(watcher.ends_after(folder), 1s);
  const auto& events = watcher.plugin.events.all;
  ASSERT_GE(events.size(), 2u);
  EXPECT_EQ(events[0].error.code(), Code::no_revocation_list);
  EXPECT_EQ(events[1].error.code(), Code::crl_renewed);
}

TEST(LaterCrl, Record_FollowsTheListInForceAndWhatIsRefused) {
  const test::TemporaryFolder folder;
  Watcher watcher(folder, property::kLaterCrl, "1");
  Participant us(watcher.plugin, watcher.identity);
  const auto recorded = [&] {
    watcher.poll();
    watcher.poll();
    return test::recorded_document(watcher.plugin.documents, "revocation list");
  };
  EXPECT_TRUE(recorded()["in_force"].empty());
  const auto path = folder.replace("crl.pem", pem({2}));
  EXPECT_EQ(recorded()["file"], path);
  EXPECT_EQ(recorded()["in_force"][0]["number"], "2");
  EXPECT_EQ(recorded()["in_force"][0]["until"], to_string(kYear.not_after));
  folder.replace("crl.pem", "nothing");
  EXPECT_EQ(recorded()["refused"]["name"], "crl_file_empty");
  EXPECT_EQ(recorded()["refused"]["stands"], true);
  EXPECT_EQ(recorded()["in_force"][0]["number"], "2");
  folder.replace("crl.pem", pem({3}));
  EXPECT_EQ(recorded()["in_force"][0]["number"], "3");
  EXPECT_EQ(recorded()["refused"]["stands"], false);
}

TEST(LaterCrl, ListThatIsThereAlready_Counts) {
  const test::TemporaryFolder folder;
  folder.write("crl.pem", pem({1, {alice().certificate}}));
  const Watcher watcher(folder, property::kLaterCrl, "1");
  TestPlugin plugin;
  const auto create = [&] {
    return plugin->validate_local_identity(0, watcher.identity.properties, candidate(1));
  };
  EXPECT_CODE(create(), certificate_revoked);
  folder.replace("crl.pem", "nothing");
  EXPECT_CODE(create(), crl_file_empty);
}

// Otherwise it would look as if the later list were watched.
TEST(LaterCrl, BesideAListThatIsNamed_IsRefused) {
  const test::TemporaryFolder folder;
  Watcher watcher(folder, property::kLaterCrl, "1");
  set(watcher.identity.properties, property::kCrl, "data:," + pem({}));
  TestPlugin plugin;
  const auto refused =
      plugin->validate_local_identity(0, watcher.identity.properties, candidate(1));
  EXPECT_CODE(refused, property_without_effect);
  EXPECT_NE(refused.error().to_sentence().find(property::kLaterCrl), std::string::npos);
}

TEST(LaterCrl, FolderOfAuthorities_IsRefusedBesideIt) {
  const test::TemporaryFolder folder, cas;
  cas.write("ca.pem", test_ca().certificate().pem());
  cas.write("other.pem", make_ca("CN=Other").certificate().pem());
  Watcher watcher(folder, property::kLaterCrl, "1");
  set(watcher.identity.properties, property::kTrustedCaDir, cas.path());
  EXPECT_FALSE(watcher.ends_after(folder));
  EXPECT_EQ(watcher.plugin.events.all.back().error.code(), Code::trusted_ca_dir_with_crl);
}

// ---- a list that no property names

// Alice's certificate, or her CA's, is in a file. No property names a list.
struct UnnamedRevocationList : testing::Test {
  UnnamedRevocationList() { set(identity.properties, property::kFilesPollInterval, "1"); }
  void put_certificate() {
    const auto path = folder.write("cert.pem", alice().certificate.pem());
    set(identity.properties, property::kIdentityCertificate, "file:" + path);
  }
  void put_ca(const test::TemporaryFolder& where) {
    const auto path = where.write("identity_ca.cert.pem", test_ca().certificate().pem());
    set(identity.properties, property::kIdentityCa, "file:" + path);
  }
  // True if Alice's identity ended within three looks.
  bool ends() {
    bool ended = false;
    for (int i = 0; i < 3; ++i) {
      plugin.clock.advance(1s);
      ended |= !plugin->poll().empty();
    }
    return ended;
  }
  std::vector<Code> codes() const { return plugin.events.codes(); }
  Status create() {
    const auto made = plugin->validate_local_identity(0, identity.properties, candidate(1));
    if (!made) return std::unexpected(made.error());
    return {};
  }
  const test::TemporaryFolder folder, elsewhere;
  Identity identity = alice();
  TestPlugin plugin;
};
const std::string& revokes_alice() {
  static const auto text = pem({9, {alice().certificate}});
  return text;
}

TEST_F(UnnamedRevocationList, List_ComesBesideTheCertificate_IsTaken) {
  put_certificate();
  ASSERT_OK(create());
  EXPECT_FALSE(ends());
  folder.replace("crl.pem", revokes_alice());
  EXPECT_TRUE(ends());
  EXPECT_THAT(codes(), testing::ElementsAre(Code::no_revocation_list, Code::crl_renewed,
                                            Code::certificate_revoked));
}

TEST_F(UnnamedRevocationList, List_ComesBesideTheCa_IsTaken) {
  put_certificate();
  put_ca(elsewhere);
  ASSERT_OK(create());
  EXPECT_FALSE(ends());
  elsewhere.replace("crl.pem", revokes_alice());
  EXPECT_TRUE(ends());
}

// Alice's certificate is in `folder` and her CA in `elsewhere`.
struct TwoRevocationLists : UnnamedRevocationList {
  TwoRevocationLists() {
    put_certificate();
    put_ca(elsewhere);
  }
  // Returns the events of three looks.
  std::vector<Code> told() {
    plugin.events.all.clear();
    EXPECT_FALSE(ends());
    return codes();
  }
  const ErrorDetails& last() const { return plugin.events.all.back().error.details(); }
};

TEST_F(TwoRevocationLists, NewerList_CountsFromEither) {
  elsewhere.write("crl.pem", pem({5}));
  ASSERT_OK(create());
  EXPECT_THAT(told(), testing::IsEmpty());
  folder.replace("crl.pem", revokes_alice());
  EXPECT_TRUE(ends());
  EXPECT_THAT(codes(), testing::ElementsAre(Code::crl_renewed, Code::certificate_revoked));
  EXPECT_EQ(last().document, folder.path() + "/crl.pem");
}

TEST_F(TwoRevocationLists, NewerListBesideTheCa_CountsOverTheOneBesideTheCertificate) {
  folder.write("crl.pem", pem({5}));
  ASSERT_OK(create());
  EXPECT_THAT(told(), testing::IsEmpty());
  elsewhere.replace("crl.pem", revokes_alice());
  EXPECT_TRUE(ends());
}

TEST_F(TwoRevocationLists, NewestAtTheStart_Counts) {
  folder.write("crl.pem", pem({1}));
  elsewhere.write("crl.pem", revokes_alice());
  EXPECT_CODE(create(), certificate_revoked);
  folder.replace("crl.pem", revokes_alice());
  elsewhere.replace("crl.pem", pem({1}));
  EXPECT_CODE(create(), certificate_revoked);
  elsewhere.replace("crl.pem", "nothing");
  EXPECT_CODE(create(), crl_file_empty);
}

TEST_F(TwoRevocationLists, OlderCopy_IsReportedOnceWithBothNumbers) {
  const auto second = pem({2});
  folder.write("crl.pem", pem({1}));
  elsewhere.write("crl.pem", second);
  ASSERT_OK(create());
  EXPECT_THAT(told(), testing::ElementsAre(Code::crl_copy_older));
  EXPECT_EQ(plugin.events.all[0].severity, Severity::warning);
  EXPECT_EQ(last().document, folder.path() + "/crl.pem");
  EXPECT_THAT(last().expected, testing::HasSubstr("number 2"));
  EXPECT_THAT(last().found, testing::HasSubstr("number 1"));
  EXPECT_THAT(last().note, testing::HasSubstr(elsewhere.path() + "/crl.pem"));
  EXPECT_THAT(told(), testing::IsEmpty()) << "told twice";
  folder.replace("crl.pem", second);
  EXPECT_THAT(told(), testing::IsEmpty());
}

TEST_F(TwoRevocationLists, CopyThatFallsBehind_IsReported) {
  folder.write("crl.pem", pem({1}));
  elsewhere.write("crl.pem", pem({1}));
  ASSERT_OK(create());
  EXPECT_THAT(told(), testing::IsEmpty());
  folder.replace("crl.pem", pem({2}));
  EXPECT_THAT(told(), testing::ElementsAre(Code::crl_renewed, Code::crl_copy_older));
  EXPECT_EQ(last().document, elsewhere.path() + "/crl.pem");
}

TEST_F(TwoRevocationLists, OlderListInBoth_GoesBackInNeither) {
  const auto fifth = pem({5});
  folder.write("crl.pem", fifth);
  elsewhere.write("crl.pem", fifth);
  ASSERT_OK(create());
  told();
  folder.replace("crl.pem", pem({4}));
  EXPECT_THAT(told(), testing::ElementsAre(Code::crl_copy_older));
  elsewhere.replace("crl.pem", pem({4}));
  EXPECT_THAT(told(), testing::ElementsAre(Code::crl_older));
  folder.replace("crl.pem", revokes_alice());
  EXPECT_TRUE(ends());
}

TEST_F(TwoRevocationLists, FileThatDisappears_IsReportedAndItsListStays) {
  folder.write("crl.pem", pem({1}));
  elsewhere.write("crl.pem", pem({2}));
  ASSERT_OK(create());
  told();
  std::filesystem::remove(elsewhere.path() + "/crl.pem");
  EXPECT_THAT(told(), testing::ElementsAre(Code::file_not_found));
  EXPECT_EQ(last().document, elsewhere.path() + "/crl.pem");
  EXPECT_THAT(last().note, testing::HasSubstr("stay in force"));
  EXPECT_THAT(told(), testing::IsEmpty());
}

// The other place must be read although this one is wrong in a new way at each look.
TEST_F(TwoRevocationLists, FileThatIsWrongAtEachLook_DoesNotHideTheOther) {
  folder.write("crl.pem", pem({1}));
  elsewhere.write("crl.pem", pem({1}));
  ASSERT_OK(create());
  told();
  bool ended = false;
  for (int i = 0; i < 5; ++i) {
    folder.replace("crl.pem", "nothing " + std::to_string(i));
    if (i == 2) elsewhere.replace("crl.pem", revokes_alice());
    plugin.clock.advance(1s);
    ended |= !plugin->poll().empty();
  }
  EXPECT_TRUE(ended);
}

TEST_F(TwoRevocationLists, ForgedList_ReplacesNone) {
  folder.write("crl.pem", pem({5}));
  const auto forger = make_ca();  // has the same name as the CA
  ASSERT_OK(create());
  told();
  elsewhere.replace("crl.pem", pem({99}, forger));
  EXPECT_THAT(told(), testing::ElementsAre(Code::crl_signature_invalid));
  EXPECT_EQ(last().document, elsewhere.path() + "/crl.pem");
  elsewhere.replace("crl.pem", pem({4}, forger));
  EXPECT_THAT(told(), testing::ElementsAre(Code::crl_signature_invalid));
  folder.replace("crl.pem", revokes_alice());
  EXPECT_TRUE(ends());
}

TEST_F(TwoRevocationLists, ListOfOneCaThatHasEnded_KeepsNoOtherBack) {
  const auto other = make_ca("CN=Other CA");
  elsewhere.write("identity_ca.cert.pem",
                  test_ca().certificate().pem() + other.certificate().pem());
  folder.write("crl.pem", pem({1}));
  elsewhere.write("crl.pem", pem({1, {}, kNow - 1h, kNow + 2h}, other));
  ASSERT_OK(create());
  plugin.clock.advance(3h);
  told();
  elsewhere.replace("crl.pem", pem({2, {}, kNow, kNow + 2h}, other));
  EXPECT_THAT(told(), testing::ElementsAre(Code::crl_expired)) << "a new list must be valid";
  folder.replace("crl.pem", revokes_alice());
  EXPECT_TRUE(ends());
}

// The list of an intermediate CA counts although that of the CA above it has ended.
TEST_F(TwoRevocationLists, ListOfTheCaAboveThatHasEnded_KeepsNoRevocationBack) {
  const auto root = make_ca("CN=Root CA");
  const auto below = root.subordinate("CN=Plant CA", {}, kYear, plugin.random).value();
  const auto member = make_identity(below, "CN=alice,O=Example");
  folder.replace("cert.pem", member.certificate.pem());
  elsewhere.replace("identity_ca.cert.pem", below.certificate().pem() + root.certificate().pem());
  folder.write("crl.pem", pem({1}, below));
  elsewhere.write("crl.pem", pem({1, {}, kNow - 1h, kNow + 2h}, root));
  ASSERT_OK(create());
  plugin.clock.advance(3h);
  ends();
  plugin.events.all.clear();
  folder.replace("crl.pem", pem({2, {member.certificate}}, below));
  ends();
  EXPECT_THAT(codes(), testing::Contains(Code::crl_renewed));
}

// The key of the CA was stolen, and its last list is still in one of the two places.
TEST_F(TwoRevocationLists, ListOfAReplacedCa_StopsNoSuccessor) {
  folder.write("crl.pem", pem({7}));
  elsewhere.write("crl.pem", pem({7}));
  ASSERT_OK(create());
  told();
  const auto successor = make_ca();
  const auto next =
      make_identity(successor, "CN=alice,O=Example", {}, {kNow, kYear.not_after}).certificate;
  elsewhere.replace("crl.pem", pem({1}, successor));
  folder.replace("cert.pem", next.pem());
  elsewhere.replace("identity_ca.cert.pem", successor.certificate().pem());
  EXPECT_THAT(told(), testing::IsSupersetOf({Code::identity_ca_renewed, Code::identity_renewed}));
  elsewhere.replace("crl.pem", pem({2, {next}}, successor));
  EXPECT_TRUE(ends());
}

TEST_F(TwoRevocationLists, ListsOfTwoCas_CountTogether) {
  const auto other = make_ca("CN=Other CA");
  elsewhere.write("identity_ca.cert.pem",
                  test_ca().certificate().pem() + other.certificate().pem());
  folder.write("crl.pem", pem({1}));
  elsewhere.write("crl.pem", pem({1}, other));
  ASSERT_OK(create());
  EXPECT_THAT(told(), testing::IsEmpty());
  elsewhere.replace("crl.pem", pem({2}, other));
  EXPECT_THAT(told(), testing::ElementsAre(Code::crl_renewed));
  elsewhere.replace("crl.pem", pem({2}));
  EXPECT_THAT(told(), testing::ElementsAre(Code::crl_missing)) << "the other CA's list is lost";
  folder.replace("crl.pem", revokes_alice());
  EXPECT_TRUE(ends());
}

TEST_F(UnnamedRevocationList, List_ThereAtTheStart_Counts) {
  put_certificate();
  folder.write("crl.pem", revokes_alice());
  EXPECT_CODE(create(), certificate_revoked);
  folder.replace("crl.pem", "nothing");
  EXPECT_CODE(create(), crl_file_empty);
  folder.replace("crl.pem", pem({}));
  EXPECT_TRUE(create());
  EXPECT_EQ(codes().size(), 2u) << "a participant with a list does not say that it has none";
}

TEST_F(UnnamedRevocationList, List_ThatIsInvalidOrForeign_ChangesNothingAndIsReported) {
  put_certificate();
  ASSERT_OK(create());
  const auto stranger = make_ca("CN=Stranger");
  const auto forger = make_ca();  // has the same name as the CA
  const std::pair<std::string, Code> lists[] = {
      {"nothing", Code::crl_file_empty},
      {pem({9, {alice().certificate}}, stranger), Code::crl_missing},
      {pem({9, {alice().certificate}}, forger), Code::crl_signature_invalid},
      {pem({9, {alice().certificate}, kNow - 48h, kNow - 24h}), Code::crl_expired}};
  for (const auto& [text, code] : lists) {
    plugin.events.all.clear();
    folder.replace("crl.pem", text);
    EXPECT_FALSE(ends());
    ASSERT_EQ(codes(), std::vector{code});
    const auto& details = plugin.events.all[0].error.details();
    EXPECT_EQ(details.document, folder.path() + "/crl.pem");
    EXPECT_THAT(details.note, testing::HasSubstr("still no revocation list"));
  }
  folder.replace("crl.pem", revokes_alice());
  EXPECT_TRUE(ends());
}

TEST_F(UnnamedRevocationList, NoList_IsSaidOnceWithItsPlace) {
  put_certificate();
  ASSERT_OK(create());
  EXPECT_FALSE(ends());
  ASSERT_EQ(codes(), std::vector{Code::no_revocation_list});
  const auto& event = plugin.events.all[0];
  EXPECT_EQ(event.severity, Severity::informational);
  EXPECT_THAT(event.error.details().note,
              testing::HasSubstr(folder.path() + "/crl.pem is looked for every 1 s"));
  EXPECT_NE(event.guid, "");
}

TEST_F(UnnamedRevocationList, NoList_WithoutLooking_SaysThatNoneIsLookedFor) {
  put_certificate();
  set(identity.properties, property::kFilesPollInterval, "0");
  ASSERT_OK(create());
  EXPECT_THAT(plugin.events.all.at(0).error.details().note,
              testing::HasSubstr("is not looked for, since org.ddssec.files_poll_interval is 0"));
  folder.write("crl.pem", revokes_alice());
  EXPECT_FALSE(ends());
}

TEST_F(UnnamedRevocationList, FolderOfAuthorities_NoListIsLookedFor) {
  put_certificate();
  elsewhere.write("ca.pem", test_ca().certificate().pem());
  set(identity.properties, property::kTrustedCaDir, elsewhere.path());
  ASSERT_OK(create());
  folder.write("crl.pem", revokes_alice());
  EXPECT_FALSE(ends());
  EXPECT_TRUE(codes().empty());
}

// ---- two participants of one process with the same files

// The second participant is made between two looks of the first one, so they look at different
// times.
struct TwoParticipantsWithOneList : UnnamedRevocationList {
  TwoParticipantsWithOneList() {
    identity = make_identity(test_ca(), "CN=alice,O=Example", {}, {kNow - 24h, kEnd});
    set(identity.properties, property::kFilesPollInterval, "5");
    const auto path = folder.write("cert.pem", identity.certificate.pem());
    set(identity.properties, property::kIdentityCertificate, "file:" + path);
    first.emplace(plugin, identity, 1);
    pass(7s);
    second.emplace(plugin, identity, 2);
    pass(10s);
  }
  // Returns the identities that ended at the first look at which any of them did.
  std::vector<IdentityHandle> pass(std::chrono::seconds time) {
    for (; time > 0s; time -= 1s) {
      plugin.clock.advance(1s);
      if (auto ended = plugin->poll(); !ended.empty()) return ended;
    }
    return {};
  }
  static constexpr auto kEnd = kNow + std::chrono::days(100);
  std::optional<Participant> first, second;
};

TEST_F(TwoParticipantsWithOneList, ListThatNamesBoth_EndsBothAtOnce) {
  for (int i = 0; i < 4; ++i) {
    folder.replace("crl.pem", pem({static_cast<std::uint64_t>(i + 1), {}}));
    EXPECT_THAT(pass(6s), testing::IsEmpty());
    pass(std::chrono::seconds(i));  // changes the distance from the next look of each
  }
  folder.replace("crl.pem", pem({9, {identity.certificate}}));
  EXPECT_THAT(pass(6s), testing::UnorderedElementsAre(first->handle, second->handle));
}

TEST_F(TwoParticipantsWithOneList, CertificateRenewedJustBeforeItsEnd_IsTakenByBoth) {
  const auto renewed = make_identity(test_ca(), "CN=alice,O=Example", {}, {kNow, kEnd + 24h});
  plugin.clock.advance(kEnd - plugin.clock.calendar_seconds() - 8s);
  pass(7s);
  folder.replace("cert.pem", renewed.certificate.pem());
  EXPECT_THAT(pass(20s), testing::IsEmpty());
  EXPECT_TRUE(plugin->identity_token(first->handle));
  EXPECT_TRUE(plugin->identity_token(second->handle));
}

}  // namespace
}  // namespace ddssec::authentication
