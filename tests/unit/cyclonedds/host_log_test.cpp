#include "plugins/cyclonedds/host_log.hpp"

#include <csignal>
#include <cstdarg>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <dds/ddsrt/log.h>
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace ddssec::cyclonedds {
namespace {

struct Line {
  std::uint32_t category;
  std::string text;
};
std::vector<Line> logged;

void record(std::uint32_t category, const char*, std::uint32_t, const char*, const char* format,
            ...) {
  char text[2048];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  logged.push_back({category, text});
}

struct HostLog : testing::Test {
  HostLog() { logged.clear(); }
  ~HostLog() override { std::filesystem::remove(json_path); }
  const std::string json_path =
      std::filesystem::temp_directory_path() / ("ddssec_log_test_" + std::to_string(getpid()));
};

TEST_F(HostLog, EachEvent_IsOneSentenceInTheHostsLog) {
  make_host_log(record, nullptr)->raise(Event(Error(Code::malformed, {.document = "%s%n"})));
  ASSERT_EQ(logged.size(), 1u);
  EXPECT_EQ(logged[0].category, DDS_LC_WARNING);
  EXPECT_THAT(logged[0].text, testing::StartsWith("ddssec warning:"));
  EXPECT_THAT(logged[0].text, testing::HasSubstr("%s%n"));
  EXPECT_EQ(std::ranges::count(logged[0].text, '\n'), 1);
}

TEST_F(HostLog, JsonLines_AreAppended) {
  for (int i = 0; i < 2; ++i)
    make_host_log(record, json_path.c_str())->raise(Event(Error(Code::file_not_found), "CN=x"));
  std::ifstream file(json_path);
  int lines = 0;
  for (std::string line; std::getline(file, line); ++lines)
    EXPECT_EQ(nlohmann::json::parse(line).at("code"), static_cast<int>(Code::file_not_found));
  EXPECT_EQ(lines, 2);
}

TEST_F(HostLog, AFileThatCannotBeWritten_IsSaidOnce) {
  const auto log = make_host_log(record, "/nowhere/at/all");
  log->raise(Event(Error(Code::malformed)));
  ASSERT_EQ(logged.size(), 2u);
  EXPECT_THAT(logged[0].text, testing::HasSubstr("event_log_unwritable"));
  EXPECT_THAT(logged[0].text, testing::HasSubstr("No such file or directory"));
}

TEST_F(HostLog, AFullDisk_IsSaidOnce) {
  const auto log = make_host_log(record, "/dev/full");
  for (int i = 0; i < 3; ++i) log->raise(Event(Error(Code::malformed)));
  const auto is_about_the_file = [](const Line& line) {
    return line.text.find("event_log_unwritable") != line.text.npos;
  };
  EXPECT_EQ(std::ranges::count_if(logged, is_about_the_file), 1);
  EXPECT_EQ(logged.size(), 4u);
}

// Log shippers read from FIFOs.
struct EventFifo : HostLog {
  EventFifo() { EXPECT_EQ(mkfifo(json_path.c_str(), 0600), 0); }
  ~EventFifo() override {
    if (reader >= 0) close(reader);
  }
  void read_it() { reader = open(json_path.c_str(), O_RDONLY | O_NONBLOCK); }
  std::string received() const {
    std::string out;
    char part[4096];
    for (ssize_t size; (size = read(reader, part, sizeof part)) > 0;)
      out.append(part, static_cast<std::size_t>(size));
    return out;
  }
  // Returns the names of the events in the received lines; "" for a line that was cut.
  std::vector<std::string> names() const {
    std::vector<std::string> out;
    std::istringstream lines(received());
    for (std::string line; std::getline(lines, line);) {
      const auto event = nlohmann::json::parse(line, nullptr, false);
      out.push_back(event.is_discarded() ? "" : event.at("name").get<std::string>());
    }
    return out;
  }
  int reader = -1;
};

TEST_F(EventFifo, FifoWithoutAReader_IsReportedAndHoldsUpNothing) {
  const auto log = make_host_log(record, json_path.c_str());
  ASSERT_EQ(logged.size(), 1u);
  EXPECT_THAT(logged[0].text, testing::HasSubstr("event_log_unwritable"));
}

TEST_F(EventFifo, FifoWithAReader_TakesLines) {
  read_it();
  make_host_log(record, json_path.c_str())->raise(Event(Error(Code::malformed)));
  const auto line = received();
  EXPECT_EQ(nlohmann::json::parse(line).at("name"), "malformed");
  EXPECT_THAT(line, testing::EndsWith("\n"));
}

TEST_F(EventFifo, FullFifo_LosesLinesAndHoldsUpNothing) {
  read_it();
  const auto log = make_host_log(record, json_path.c_str());
  // This is longer than what a FIFO takes as a whole or not at all.
  const std::string text(1'000, 'x');
  const Event event(
      Error(Code::malformed,
            {.document = text, .field = text, .expected = text, .found = text, .hint = text}));
  for (int i = 0; i < 200; ++i) log->raise(event);
  EXPECT_LT(received().size(), 200u * 1'000u);
  log->raise(event);
  const auto lines = names();
  ASSERT_GE(lines.size(), 2u);
  EXPECT_EQ(lines[lines.size() - 2], "malformed") << "a line of its own again";
  EXPECT_EQ(lines.back(), "event_log_unwritable") << "how many are missing";
}

TEST_F(EventFifo, FifoThatItsReaderClosed_DoesNotEndTheProcess) {
  read_it();
  const auto log = make_host_log(record, json_path.c_str());
  close(std::exchange(reader, -1));
  log->raise(Event(Error(Code::malformed)));
  sigset_t pending;
  ASSERT_EQ(sigpending(&pending), 0);
  EXPECT_EQ(sigismember(&pending, SIGPIPE), 0);
  read_it();
  log->raise(Event(Error(Code::file_not_found)));
  EXPECT_THAT(names(), testing::ElementsAre("file_not_found", "event_log_unwritable"));
}

TEST_F(HostLog, WhatIsNoPlaceForLines_IsRefused) {
  const auto folder = std::filesystem::temp_directory_path().string();
  make_host_log(record, folder.c_str());
  ASSERT_EQ(logged.size(), 1u);
  EXPECT_THAT(logged[0].text, testing::HasSubstr("event_log_unwritable"));
  logged.clear();
  make_host_log(record, "/dev/stderr");
  EXPECT_TRUE(logged.empty());
}

TEST_F(HostLog, NoSeverity_Aborts) {
  EXPECT_EQ(log_category(Severity::debug), 0u);
  EXPECT_EQ(log_category(Severity::informational), DDS_LC_INFO);
  EXPECT_EQ(log_category(Severity::warning), DDS_LC_WARNING);
  EXPECT_EQ(log_category(Severity::error), DDS_LC_ERROR);
  EXPECT_EQ(log_category(Severity::critical), DDS_LC_ERROR);
  auto quiet = Event(Error(Code::malformed));
  quiet.severity = Severity::debug;
  make_host_log(record, nullptr)->raise(quiet);
  EXPECT_TRUE(logged.empty());
}

// Cyclone DDS shows errors and warnings only, unless its configuration asks for more.
TEST_F(HostLog, NoticesThatMustBeSeen_ByDefault_AreShown) {
  const Code shown[] = {Code::plugins_in_use, Code::no_revocation_list, Code::crl_renewed};
  for (const auto code : shown) make_host_log(record, nullptr)->raise(Event(Error(code)));
  make_host_log(record, nullptr)->raise(Event(Error(Code::clock_step_undone)));
  ASSERT_EQ(logged.size(), 4u);
  for (std::size_t i = 0; i < std::size(shown); ++i) {
    EXPECT_EQ(logged[i].category, DDS_LC_WARNING);
    EXPECT_THAT(logged[i].text, testing::StartsWith("ddssec informational:"));
  }
  EXPECT_THAT(logged[1].text, testing::HasSubstr("ddssec crl distribute"));
  EXPECT_EQ(logged[3].category, DDS_LC_INFO);
}

TEST_F(HostLog, EventWithoutAHost_GoesToStderr) {
  testing::internal::CaptureStderr();
  make_host_log(nullptr, nullptr)->raise(Event(Error(Code::malformed)));
  EXPECT_THAT(testing::internal::GetCapturedStderr(), testing::HasSubstr("malformed"));
}

}  // namespace
}  // namespace ddssec::cyclonedds
