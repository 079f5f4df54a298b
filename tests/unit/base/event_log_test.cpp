// The file with a JSON object for each event, and what is reported if it cannot be written.
#include "base/event_log.hpp"

#include <cstdlib>
#include <fcntl.h>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/file_descriptor.hpp"
#include "tests/support/recorded_events.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec {
namespace {

Event event(std::string found = "x") {
  return Event(Error(Code::malformed, {.found = std::move(found)}));
}

class EventLogTest : public testing::Test {
 protected:
  ~EventLogTest() override { ::unsetenv("DDSSEC_EVENT_LOG"); }
  std::vector<nlohmann::json> lines() const {
    std::vector<nlohmann::json> out;
    std::ifstream file(path_);
    for (std::string line; std::getline(file, line);) out.push_back(nlohmann::json::parse(line));
    return out;
  }
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() + "/events";
};

TEST_F(EventLogTest, EachEvent_IsALineWithItsTime) {
  EventLog log(path_.c_str());
  EXPECT_FALSE(log.append(event("1")));
  EXPECT_FALSE(log.append(event("2")));
  const auto written = lines();
  ASSERT_EQ(written.size(), 2u);
  EXPECT_EQ(written[1]["found"], "2");
  EXPECT_EQ(written[1]["name"], "malformed");
  EXPECT_TRUE(written[1].contains("time"));
}

TEST_F(EventLogTest, LogWithoutAPath_WritesNothingAndReportsNoError) {
  for (const char* path : {static_cast<const char*>(nullptr), ""}) {
    EventLog log(path);
    EXPECT_FALSE(log.write_failure());
    EXPECT_FALSE(log.append(event()));
  }
}

TEST_F(EventLogTest, FileOfTheEnvironment_IsTheOneThatItNamesNow) {
  ::setenv("DDSSEC_EVENT_LOG", path_.c_str(), 1);
  auto log = EventLog::of_environment();
  ::unsetenv("DDSSEC_EVENT_LOG");
  log.append(event());
  EXPECT_EQ(lines().size(), 1u);
}

TEST_F(EventLogTest, FileThatCannotBeOpened_IsReportedWithTheReason) {
  const auto folder = folder_.path();
  EventLog log(folder.c_str());
  ASSERT_TRUE(log.write_failure());
  EXPECT_EQ(log.write_failure()->error.code(), Code::event_log_unwritable);
  EXPECT_EQ(log.write_failure()->error.details().document, folder);
  EXPECT_FALSE(log.write_failure()->error.details().found.empty());
  EXPECT_FALSE(log.append(event()));
}

TEST_F(EventLogTest, LostEvents_AreReportedOnceAndCounted) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  const FileDescriptor reader(::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  EventLog log(path_.c_str());
  const auto large = event(std::string(300, 'x'));
  std::optional<Event> told;
  for (int i = 0; i < 1000 && !told; ++i) told = log.append(large);
  ASSERT_TRUE(told) << "a FIFO that takes everything";
  EXPECT_EQ(told->error.code(), Code::event_log_unwritable);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(log.append(large)) << "told again";
  std::string piece(65'536, '\0');
  while (::read(reader.number(), piece.data(), piece.size()) > 0) {
  }
  told = log.append(event());
  ASSERT_TRUE(told);
  EXPECT_EQ(told->error.details().found, "5 events before this one are lost");
  EXPECT_FALSE(log.append(event()));
}

TEST_F(EventLogTest, LoggedEvents_GoBothToTheFileAndOn) {
  test::RecordedEvents recorder;
  LoggedEvents events(recorder, EventLog(path_.c_str()));
  events.raise(event());
  EXPECT_EQ(recorder.all.size(), 1u);
  EXPECT_EQ(lines().size(), 1u);
}

TEST_F(EventLogTest, LoggedEvents_SayThatThereIsNoFile) {
  test::RecordedEvents recorder;
  LoggedEvents events(recorder, EventLog("/no/such/folder/events"));
  ASSERT_EQ(recorder.all.size(), 1u);
  EXPECT_EQ(recorder.all[0].error.code(), Code::event_log_unwritable);
  events.raise(event());
  EXPECT_EQ(recorder.all.size(), 2u);
}

}  // namespace
}  // namespace ddssec
