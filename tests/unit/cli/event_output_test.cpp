// Events of the agent, and a reader that stops.
#include "cli/agent/event_output.hpp"

#include <algorithm>
#include <array>
#include <csignal>
#include <fcntl.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/file_descriptor.hpp"

namespace ddssec::cli {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

// A pipe of two pages. It takes a line if one of them is free.
class Pipe {
 public:
  Pipe() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC), 0);
    std::ranges::copy(ends, ends_.begin());
    ::fcntl(ends_[1], F_SETPIPE_SZ, 8192);
    ::fcntl(ends_[0], F_SETFL, O_NONBLOCK);
  }
  ~Pipe() {
    close_reader();
    ::close(ends_[1]);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  int in() const { return ends_[1]; }
  void close_reader() {
    if (ends_[0] >= 0) ::close(ends_[0]);
    ends_[0] = -1;
  }
  std::string read_all() const {
    std::string out;
    std::array<char, 4096> part{};
    for (ssize_t size = 0; (size = ::read(ends_[0], part.data(), part.size())) > 0;)
      out.append(part.data(), static_cast<std::size_t>(size));
    return out;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

class EventOutputTest : public testing::Test {
 protected:
  void SetUp() override { ::signal(SIGPIPE, SIG_IGN); }
  static std::string line(char letter, std::size_t size) {
    return std::string(size, letter) + '\n';
  }

  Pipe output_, errors_;
  EventOutput events_{output_.in(), errors_.in(), 50ms};
};

TEST_F(EventOutputTest, Lines_ReachTheReader) {
  events_.put("one\n");
  events_.put("two\n");
  EXPECT_EQ(output_.read_all(), "one\ntwo\n");
  EXPECT_EQ(errors_.read_all(), "");
}

TEST_F(EventOutputTest, ReaderThatStops_LosesLinesAndItIsReportedOnceEach) {
  for (const char letter : {'a', 'b'}) events_.put(line(letter, 4000));
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 100; ++i) events_.put(line('c', 4000));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, 1s)
      << "a stopped reader costs time only once";
  auto said = errors_.read_all();
  EXPECT_THAT(said, HasSubstr("events_lost"));
  EXPECT_THAT(said, HasSubstr("nothing reads it"));
  EXPECT_EQ(said.find("events_lost"), said.rfind("events_lost"));
  EXPECT_EQ(output_.read_all(), line('a', 4000) + line('b', 4000));
  events_.put("next\n");
  EXPECT_THAT(errors_.read_all(), HasSubstr("100 lost"));
  events_.put("last\n");
  EXPECT_EQ(errors_.read_all(), "");
  EXPECT_THAT(output_.read_all(), testing::EndsWith("next\nlast\n"));
}

TEST_F(EventOutputTest, LineThatIsCut_EndsBeforeTheNextOne) {
  events_.put(line('a', 12000));  // more than both pages
  const auto before = output_.read_all();
  EXPECT_FALSE(before.empty());
  events_.put("next\n");
  const auto all = before + output_.read_all();
  EXPECT_THAT(all, testing::EndsWith("\nnext\n"));
}

TEST_F(EventOutputTest, ReaderThatHasEnded_IsReportedWithItsReason) {
  output_.close_reader();
  events_.put("one\n");
  EXPECT_THAT(errors_.read_all(), HasSubstr("Broken pipe"));
}

TEST_F(EventOutputTest, FileWithoutRoom_IsReportedWithItsReason) {
  const FileDescriptor full(::open("/dev/full", O_WRONLY | O_CLOEXEC));
  EventOutput events(full.number(), errors_.in(), 50ms);
  events.put("one\n");
  EXPECT_THAT(errors_.read_all(), HasSubstr("No space left"));
}

}  // namespace
}  // namespace ddssec::cli
