// An output for lines that must never stop the caller.
#include "base/line_file.hpp"

#include <csignal>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "base/file_descriptor.hpp"
#include "tests/support/temporary_folder.hpp"

namespace ddssec {
namespace {

class LineFileTest : public testing::Test {
 protected:
  std::string text() const {
    std::ostringstream out;
    out << std::ifstream(path_).rdbuf();
    return out.str();
  }
  const test::TemporaryFolder folder_;
  const std::string path_ = folder_.path() + "/events";
};

TEST_F(LineFileTest, NewFile_IsNotReadableByOthers) {
  const auto before = ::umask(0);
  LineFile file(path_.c_str());
  ::umask(before);
  ASSERT_TRUE(file.is_open());
  struct stat found {};
  ASSERT_EQ(::stat(path_.c_str(), &found), 0);
  EXPECT_EQ(found.st_mode & 0777, 0640u);
}

TEST_F(LineFileTest, LinesOfSeveralWriters_AreAppended) {
  folder_.write("events", "before\n");
  LineFile one(path_.c_str()), other(path_.c_str());
  EXPECT_TRUE(one.append("first"));
  EXPECT_TRUE(other.append("second"));
  EXPECT_TRUE(one.append(""));
  EXPECT_EQ(text(), "before\nfirst\nsecond\n\n");
}

TEST_F(LineFileTest, WhatIsNoOutput_IsNotOpenedAndSaysWhy) {
  EXPECT_FALSE(LineFile(folder_.path().c_str()).is_open());
  EXPECT_EQ(LineFile((folder_.path() + "/no/such/folder").c_str()).why_not(),
            "No such file or directory");
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  const LineFile fifo(path_.c_str());
  EXPECT_FALSE(fifo.is_open());
  EXPECT_EQ(fifo.why_not(), "a FIFO without a reader");
}

TEST_F(LineFileTest, SlowReaderOfAFifo_LosesLinesAndDelaysNoCaller) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  const FileDescriptor reader(::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  LineFile file(path_.c_str());
  ASSERT_TRUE(file.is_open());
  // With its line end, this is the most that is written at once or not at all.
  const std::string line(4095, 'x');
  int written = 0;
  while (file.append(line)) ASSERT_LT(++written, 1000);
  EXPECT_GT(written, 0);
  std::string piece(4096, '\0');
  ASSERT_EQ(::read(reader.number(), piece.data(), piece.size()), 4096);
  EXPECT_TRUE(file.append(line)) << "there is room again";
}

TEST_F(LineFileTest, ReaderThatHasLeft_EndsNoProcess) {
  ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
  FileDescriptor reader(::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  LineFile file(path_.c_str());
  reader = FileDescriptor();
  EXPECT_FALSE(file.append("lost"));  // without the guard, SIGPIPE ends this test
  sigset_t pending;
  sigpending(&pending);
  EXPECT_EQ(sigismember(&pending, SIGPIPE), 0);
}

// While it lives, no file of this process grows beyond this size.
class SizeLimit {
 public:
  explicit SizeLimit(rlim_t most) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{most, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, SIG_DFL);
  }
  SizeLimit(const SizeLimit&) = delete;
  SizeLimit& operator=(const SizeLimit&) = delete;

 private:
  rlimit before_{};
};

// As on a full disk, a part of the line is written, and then nothing.
TEST_F(LineFileTest, LineAfterOneThatWasCut_BeginsOnALineOfItsOwn) {
  LineFile file(path_.c_str());
  {
    const SizeLimit limit(4);
    EXPECT_FALSE(file.append("longer than four"));
    EXPECT_FALSE(file.append("lost whole"));
  }
  EXPECT_TRUE(file.append("next"));
  EXPECT_TRUE(file.append("last"));
  EXPECT_EQ(text(), "long\nnext\nlast\n");
}

}  // namespace
}  // namespace ddssec
