// When a file that cannot be used is reported, and with which text.
#include "base/renewal_refusals.hpp"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "base/document_watch.hpp"
#include "base/uri_source.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec {
namespace {

constexpr Sha256Digest kOne{1}, kOther{2};

TEST(RenewalRefusals, FileThatIsWrongOnce_IsNotReported) {
  RenewalRefusals refusals;
  EXPECT_FALSE(refusals.note_refusal(Code::malformed, kOne))
      << "it may be in the middle of a write";
  refusals.clear();
  EXPECT_FALSE(refusals.note_refusal(Code::malformed, kOne)) << "it was good in between";
}

TEST(RenewalRefusals, FileThatStaysWrong_IsReportedOnce) {
  RenewalRefusals refusals;
  refusals.note_refusal(Code::malformed, kOne);
  EXPECT_TRUE(refusals.note_refusal(Code::malformed, kOne));
  EXPECT_FALSE(refusals.note_refusal(Code::malformed, kOne));
}

TEST(RenewalRefusals, OtherContentOrOtherReason_IsReportedAgain) {
  RenewalRefusals refusals;
  refusals.note_refusal(Code::malformed, kOne);
  EXPECT_TRUE(refusals.note_refusal(Code::malformed, kOne));
  EXPECT_TRUE(refusals.note_refusal(Code::malformed, kOther));
  EXPECT_TRUE(refusals.note_refusal(Code::truncated, kOther));
}

TEST(RenewalRefusals, LastReport_StandsUntilTheFileIsGood) {
  RenewalRefusals refusals;
  EXPECT_FALSE(refusals.refused());
  EXPECT_EQ(refusals.note(Error(Code::malformed)).code(), Code::malformed);
  ASSERT_TRUE(refusals.refused());
  EXPECT_EQ(refusals.refused()->code(), Code::malformed);
  refusals.clear();
  EXPECT_FALSE(refusals.refused());
}

TEST(RenewalRefusals, State_IsCurrentThenCandidateThenRefused) {
  RenewalRefusals refusals;
  EXPECT_EQ(refusals.state(), FileState::current);
  refusals.note_refusal(Code::malformed, kOne);
  EXPECT_EQ(refusals.state(), FileState::candidate);
  refusals.note_refusal(Code::malformed, kOne);
  refusals.note(Error(Code::identity_renewal_refused));
  EXPECT_EQ(refusals.state(), FileState::refused);
  refusals.clear();
  EXPECT_EQ(refusals.state(), FileState::current);
  refusals.note_doubt();
  EXPECT_EQ(refusals.state(), FileState::candidate);
}

TEST(RenewalRefusals, DocumentThatBeginsLater_StaysACandidate) {
  for (const auto later : {Code::certificate_not_yet_valid, Code::crl_not_yet_valid,
                           Code::grant_not_yet_valid, Code::ocsp_not_yet_valid}) {
    RenewalRefusals refusals;
    for (int i = 0; i < 2; ++i) refusals.note_refusal(later, kOne);
    refusals.note(Error(Code::identity_renewal_refused));
    EXPECT_EQ(refusals.state(), FileState::candidate);
    EXPECT_TRUE(refusals.note_refusal(Code::malformed, kOther));
    refusals.note(Error(Code::identity_renewal_refused));
    EXPECT_EQ(refusals.state(), FileState::refused);
  }
}

TEST(RenewalRefusals, SameRefusal_IsReportedAgainOnceOnDemand) {
  RenewalRefusals refusals;
  for (int i = 0; i < 2; ++i) refusals.note_refusal(Code::malformed, kOne);
  refusals.report_again();
  EXPECT_TRUE(refusals.note_refusal(Code::malformed, kOne));
  EXPECT_FALSE(refusals.note_refusal(Code::malformed, kOne));
  refusals.report_again();
  refusals.clear();
  EXPECT_FALSE(refusals.note_refusal(Code::malformed, kOne)) << "the file was good in between";
}

TEST(RenewalRefused, Event_SaysTheReasonTheNoteAndWhatStays) {
  const Error why(Code::malformed, {.document = "a property",
                                    .field = "notAfter",
                                    .found = "1",
                                    .note = "noted",
                                    .hint = "of the reason"});
  const auto told = renewal_refused_error(Code::identity_renewal_refused, why, "/etc/cert.pem",
                                          "the former stays");
  EXPECT_EQ(told.code(), Code::identity_renewal_refused);
  EXPECT_EQ(told.details().document, "/etc/cert.pem");
  EXPECT_EQ(told.details().field, "notAfter");
  EXPECT_EQ(told.details().found, "1");
  EXPECT_EQ(told.details().note,
            std::string(info(Code::malformed).summary) + "; noted; the former stays");
  EXPECT_EQ(told.hint(), info(Code::identity_renewal_refused).hint);
}

TEST(RenewalRefused, ReasonOfTheSameCode_KeepsItsHintAndIsNotRepeated) {
  const Error why(Code::identity_renewal_refused, {.hint = "do this"});
  const auto told =
      renewal_refused_error(Code::identity_renewal_refused, why, "/etc/cert.pem", "it stays");
  EXPECT_EQ(told.details().note, "it stays");
  EXPECT_EQ(told.hint(), "do this");
}

void become_another_user() {
  if (::geteuid() != 0) return;
  ASSERT_EQ(::setgid(65534), 0);
  ASSERT_EQ(::setuid(65534), 0);
}

// Runs the expectations of `f` in a child process of a user that is not root. The child prints
// those that fail.
template <class F>
void expect_as_another_user(F&& f) {
  std::fflush(stdout);  // or the child would print it again
  const auto child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    become_another_user();
    if (!testing::Test::HasFailure()) f();
    std::fflush(stdout);
    ::_exit(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = -1;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(status, 0) << "see the failures of the child process";
}

// A folder that other users cannot enter.
struct ClosedFolder : testing::Test {
  void SetUp() override {
    std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
    for (const auto* name : {"a.pem", "b.pem"}) folder.write(name, "text");
    std::filesystem::create_directory(closed);
    std::ofstream(closed + "/a.pem") << "text";
    std::filesystem::permissions(folder.path(), std::filesystem::perms::all);
    std::filesystem::permissions(closed, std::filesystem::perms::none);
  }
  void TearDown() override {
    std::filesystem::permissions(closed, std::filesystem::perms::owner_all);
  }
  const test::TemporaryFolder folder;
  const std::string closed = folder.path() + "/closed";
};

TEST_F(ClosedFolder, UnreadableFileInIt_IsReportedAsTheFolder) {
  expect_as_another_user([&] {
    const auto path = closed + "/a.pem";
    const auto file = load_uri("file:" + path, "a property", 100);
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().code(), Code::file_unreadable);
    const auto told =
        renewal_refused_error(Code::identity_renewal_refused, file.error(), path, "stays");
    EXPECT_EQ(told.code(), Code::folder_unreadable);
    EXPECT_EQ(told.details().document, closed);
  });
}

TEST_F(ClosedFolder, AllItsFiles_HaveTheSameEvent) {
  expect_as_another_user([&] {
    std::vector<Error> told;
    for (const auto code : {Code::permissions_renewal_refused, Code::governance_renewal_refused}) {
      DocumentWatch watch({.uri = "file:" + closed + "/" + std::to_string(told.size()),
                           .name = "a property",
                           .max_octets = 100,
                           .refused = code,
                           .stays = "stays",
                           .gives_remedy_of_reason = true},
                          std::chrono::seconds(1));
      const auto take = [](BytesView) { return Status(); };
      static_cast<void>(watch.poll(std::chrono::seconds(1), take));
      const auto looked = watch.poll(std::chrono::seconds(2), take);
      ASSERT_FALSE(looked);
      told.push_back(looked.error());
    }
    EXPECT_EQ(told[0].code(), Code::folder_unreadable);
    EXPECT_EQ(told[0].to_sentence(), told[1].to_sentence());
  });
}

TEST_F(ClosedFolder, FileThatIsUnreadableItself_IsNotItsFault) {
  const auto path = folder.path() + "/a.pem";
  std::filesystem::permissions(path, std::filesystem::perms::none);
  expect_as_another_user([&] {
    const auto file = load_uri("file:" + path, "a property", 100);
    ASSERT_FALSE(file);
    EXPECT_EQ(file.error().code(), Code::file_unreadable);
    EXPECT_FALSE(folder_refused(file.error(), path));
  });
}

}  // namespace
}  // namespace ddssec
