// The files of a folder that secure a participant, and the errors if they are missing. The
// installed examples show that two participants talk (tests/install).
#include "secured/participant.hpp"

#include <array>
#include <atomic>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>

#include "plugins/spi/property_names.hpp"
#include "secured/reported_calendar.hpp"
#include "secured/security_plugin_set.hpp"
#include "tests/support/recorded_events.hpp"
#include "tests/support/silent.hpp"
#include "tests/support/test_data.hpp"

namespace ddssec::rtps {

struct Text {
  std::string text;
};
template <>
struct TypeTraits<Text> {
  static constexpr std::string_view type_name = "Text";
  static constexpr auto extensibility = Extensibility::final_type;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(s.text);
  }
};

}  // namespace ddssec::rtps

namespace ddssec::secured {
namespace {

namespace fs = std::filesystem;
using ::testing::EndsWith;
using ::testing::ExitedWithCode;
using ::testing::HasSubstr;

struct Folder {
  fs::path path = fs::path(::testing::TempDir()) /
                  ("ddssec-secured-" + std::to_string(::getpid()) + "-" +
                   ::testing::UnitTest::GetInstance()->current_test_info()->name());
  Folder() { fs::create_directories(path); }
  ~Folder() { fs::remove_all(path); }
  void put(const char* name) const { std::ofstream(path / name) << "nothing good"; }
};

std::string value_of(const spi::PropertyList& properties, std::string_view name) {
  for (const auto& property : properties)
    if (property.name == name) return property.value;
  return {};
}

TEST(FolderProperties, FilesOfEitherLayout_AreNamed) {
  const Folder folder;
  auto properties = folder_properties(folder.path);
  ASSERT_TRUE(properties);
  EXPECT_EQ(properties->size(), 7u);
  EXPECT_THAT(value_of(*properties, spi::property::kIdentityCa), EndsWith("/identity_ca.pem"));
  EXPECT_THAT(value_of(*properties, spi::property::kPrivateKey), EndsWith("/key.pem"));
  folder.put("identity_ca.cert.pem");
  properties = folder_properties(folder.path);
  EXPECT_THAT(value_of(*properties, spi::property::kIdentityCa), EndsWith("/identity_ca.cert.pem"));
}

// A revocation list that a user wanted to be there must not be missing without an error.
TEST(FolderProperties, AListOfRevokedCertificates_CountsEvenAsABrokenLink) {
  const Folder folder;
  fs::create_symlink("nowhere", folder.path / "crl.pem");
  const auto properties = folder_properties(folder.path);
  EXPECT_THAT(value_of(*properties, spi::property::kCrl), EndsWith("/crl.pem"));
}

TEST(FolderProperties, AListOfRevokedCertificates_MayComeLater) {
  const Folder folder;
  const auto before = folder_properties(folder.path);
  EXPECT_EQ(value_of(*before, spi::property::kCrl), "");
  EXPECT_THAT(value_of(*before, spi::property::kLaterCrl), EndsWith("/crl.pem"));
  folder.put("crl.pem");
  const auto after = folder_properties(folder.path);
  EXPECT_THAT(value_of(*after, spi::property::kCrl), EndsWith("/crl.pem"));
  EXPECT_EQ(value_of(*after, spi::property::kLaterCrl), "");
}

TEST(FolderProperties, FurtherProperties_ComeFromAFile) {
  const Folder folder;
  std::ofstream(folder.path / "security.properties") << "dds.sec.crypto.keysize = 128\n";
  const auto properties = folder_properties(folder.path);
  ASSERT_TRUE(properties);
  EXPECT_EQ(value_of(*properties, spi::property::kKeySize), "128");
  folder.put("security.properties");
  EXPECT_EQ(folder_properties(folder.path).error().code(), Code::invalid_property);
  fs::remove(folder.path / "security.properties");
  fs::create_symlink("nowhere", folder.path / "security.properties");
  EXPECT_EQ(folder_properties(folder.path).error().code(), Code::file_not_found);
}

TEST(FolderProperties, AFurtherOneThatAFileOfTheFolderSets_IsRefused) {
  const Folder folder;
  std::ofstream(folder.path / "security.properties") << "org.ddssec.auth.later_crl = file:/else\n";
  const auto refused = folder_properties(folder.path);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::property_without_effect);
  EXPECT_THAT(refused.error().to_sentence(), HasSubstr("org.ddssec.auth.later_crl"));
}

TEST(FolderProperties, ClockStepGraceThatIsNone_IsRefused) {
  const Folder folder;
  std::ofstream(folder.path / "security.properties") << "org.ddssec.clock_step_grace = never\n";
  const auto properties = folder_properties(folder.path);
  ASSERT_TRUE(properties) << properties.error().to_sentence();
  const SystemClock clock;
  SystemRandom random;
  test::Silent quiet;
  SecurityPluginSet plugins({clock, random, quiet});
  EXPECT_EQ(plugins.set_clock_step_grace(*properties).error().code(), Code::invalid_property);
  EXPECT_EQ(plugins.security_options(folder.path).error().code(), Code::invalid_property);
}

TEST(ReportedCalendar, StepThatIsUndone_IsNotBelievedAndReportedTwice) {
  ManualClock clock(WallTime(std::chrono::days(20'000)));
  test::RecordedEvents events;
  const ReportedCalendar calendar(clock, events);
  const auto before = calendar.calendar_seconds();
  clock.set(before + std::chrono::days(9000));
  EXPECT_EQ(calendar.calendar_seconds(), before);
  EXPECT_EQ(calendar.calendar_seconds(), before);
  clock.set(before);
  EXPECT_EQ(calendar.calendar_seconds(), before);
  EXPECT_EQ(events.codes(), (std::vector{Code::clock_stepped, Code::clock_step_undone}));
}

TEST(SecuredParticipant, FolderThatDoesNotExist_GivesNoParticipant) {
  test::Silent quiet;
  const auto participant = Participant::join("/nowhere/at/all", {.domain_id = 122}, &quiet);
  ASSERT_FALSE(participant);
  EXPECT_EQ(participant.error().code(), Code::file_not_found);
  EXPECT_THAT(participant.error().to_sentence(), HasSubstr("/nowhere/at/all"));
}

std::string sentence_of(const fs::path& path) {
  const auto properties = folder_properties(path);
  return properties ? "" : properties.error().to_sentence();
}

TEST(FolderProperties, AnotherFolder_IsAnsweredWithTheParticipantsNearby) {
  const Folder folder;
  for (const auto* name : {"demo/talker", "demo/listener", "demo/ca/identity"})
    fs::create_directories(folder.path / name);
  folder.put("demo/talker/cert.pem");
  folder.put("demo/listener/identity_ca.pem");
  folder.put("demo/ca/identity/ca.pem");
  folder.put("demo/ca/identity/ca.key.pem");
  const auto demo = folder.path / "demo";
  const auto both = (demo / "listener").string() + ", " + (demo / "talker").string();
  EXPECT_THAT(sentence_of(demo / "talkr"), HasSubstr("participants here: " + both));
  EXPECT_THAT(sentence_of(demo), HasSubstr("demo is no participant's folder"));
  EXPECT_THAT(sentence_of(demo / ""), HasSubstr("it holds participants: " + both));
  EXPECT_THAT(sentence_of(demo / "ca"), HasSubstr("ca is the folder of a CA"));
  EXPECT_THAT(sentence_of(demo / "ca/identity"), HasSubstr("participants of it may be " + both));
  EXPECT_EQ(folder_properties(demo / "talker/cert.pem").error().code(), Code::file_unreadable);
  EXPECT_THAT(sentence_of(folder.path / "else/where"), HasSubstr("ddssec init"));
}

TEST(SecuredParticipant, AFileThatIsMissing_IsNamed) {
  const Folder folder;
  test::Silent quiet;
  const auto participant = Participant::join(folder.path, {.domain_id = 122}, &quiet);
  ASSERT_FALSE(participant);
  EXPECT_THAT(participant.error().to_sentence(), HasSubstr("identity_ca.pem"));
}

TEST(SecuredParticipant, TopicThatTwoThreadsUseFirst_IsCreatedOnce) {
  const Folder folder;
  const fs::path example = fs::path(test::data_path("../../certs-example"));
  for (const auto& [from, to] : std::initializer_list<std::pair<const char*, const char*>>{
           {"identity_ca.pem", "identity_ca.pem"},
           {"permissions_ca.pem", "permissions_ca.pem"},
           {"governance_sign.p7s", "governance.p7s"},
           {"radar/identity.pem", "cert.pem"},
           {"radar/identity.key", "key.pem"},
           {"radar/permissions.p7s", "permissions.p7s"}})
    fs::copy_file(example / from, folder.path / to);
  test::Silent quiet;
  auto participant = Participant::join(folder.path, {.domain_id = 122}, &quiet);
  ASSERT_TRUE(participant) << participant.error().to_sentence();
  // Both threads wait in a loop for each other, so that they look the name up at the same time.
  constexpr int kTopics = 60;
  std::atomic<int> arrived = 0;
  std::array<int, 2> refused = {};
  const auto use = [&](int& refusals) {
    for (int i = 0; i < kTopics; ++i) {
      ++arrived;
      while (arrived < 2 * (i + 1)) {
      }
      const auto writer = participant->create_writer<rtps::Text>("Topic" + std::to_string(i));
      refusals += !writer && writer.error().code() == Code::rtps_precondition_not_met;
    }
  };
  std::thread other([&] { use(refused[1]); });
  use(refused[0]);
  other.join();
  EXPECT_EQ(refused, (std::array<int, 2>{}));
}

// The program that gets the error prints it, as or_exit does.
TEST(SecuredParticipant, WhatJoinReturns_IsNotPrintedByTheDefaultSinkToo) {
  const Folder folder;
  ::testing::internal::CaptureStderr();
  const auto participant = Participant::join(folder.path, {.domain_id = 122});
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
  EXPECT_FALSE(participant);
}

TEST(StandardErrorEvents, WarningsOfWhatNoCallReturns_ArePrinted) {
  StandardErrorEvents events;
  ::testing::internal::CaptureStderr();
  events.raise(Event(Error(Code::file_unreadable, {.document = "crl.pem"})));
  events.raise(Event::of_returned(Error(Code::file_unreadable, {.document = "key.pem"})));
  const auto printed = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(printed, HasSubstr("crl.pem"));
  EXPECT_THAT(printed, ::testing::Not(HasSubstr("key.pem")));
}

TEST(StandardErrorEvents, AuthenticatedPeers_ArePrinted) {
  StandardErrorEvents events;
  ::testing::internal::CaptureStderr();
  events.raise(
      Event(Error(Code::rtps_peer_authenticated), "CN=listener", "0102", PeerProof::authenticated));
  events.raise(Event(Error(Code::rtps_keys_revised)));
  EXPECT_EQ(::testing::internal::GetCapturedStderr(),
            "informational: peer \"CN=listener\" guid 0102 a remote participant has authenticated "
            "[rtps_peer_authenticated 1726]\n");
}

TEST(StandardErrorEvents, RenewedDocuments_ArePrinted) {
  StandardErrorEvents events;
  ::testing::internal::CaptureStderr();
  events.raise(Event(Error(Code::identity_renewed)));
  events.raise(Event(Error(Code::permissions_renewed)));
  const auto printed = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(printed, HasSubstr("[identity_renewed 1371]\n"));
  EXPECT_THAT(printed, HasSubstr("[permissions_renewed 1435]\n"));
}

// The variable must have its effect for an embedded participant, too.
TEST(SecuredParticipant, EventLogOfTheEnvironment_HasEachEvent) {
  const Folder folder;
  const auto file = folder.path / "events";
  ::setenv("DDSSEC_EVENT_LOG", file.c_str(), 1);
  test::Silent quiet;
  EXPECT_FALSE(Participant::join(folder.path, {.domain_id = 122}, &quiet));
  ::unsetenv("DDSSEC_EVENT_LOG");
  std::ifstream lines(file);
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_THAT(line, ::testing::StartsWith("{\"time\":\"20"));
  EXPECT_THAT(line, HasSubstr("identity_ca.pem"));
}

TEST(SecuredParticipant, Qos_ThatAnApplicationChanges_IsReliableFromTheStart) {
  EXPECT_EQ(Participant::reader_qos().reliability.kind, rtps::ReliabilityKind::reliable);
  EXPECT_EQ(Participant::writer_qos().reliability.kind, rtps::ReliabilityKind::reliable);
}

TEST(SecuredParticipant, UnhandledError_EndsTheProgramWithItsSentence) {
  EXPECT_EXIT(or_exit<int>(fail(Code::file_unreadable, {.document = "a.pem"})), ExitedWithCode(1),
              "a.pem");
  EXPECT_EQ(or_exit(Result<int>(7)), 7);
}

}  // namespace
}  // namespace ddssec::secured
