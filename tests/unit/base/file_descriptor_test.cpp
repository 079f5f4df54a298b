#include "base/file_descriptor.hpp"

#include <fcntl.h>

#include <gtest/gtest.h>

namespace ddssec {
namespace {

bool is_open(int number) { return ::fcntl(number, F_GETFD) >= 0; }

TEST(FileDescriptor, AnAssignment_ClosesTheFormerDescriptorAtOnce) {
  FileDescriptor first(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  FileDescriptor second(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  ASSERT_TRUE(first && second);
  const int former = first.number();
  const int assigned = second.number();
  first = std::move(second);
  EXPECT_FALSE(is_open(former));
  EXPECT_EQ(first.number(), assigned);
  EXPECT_TRUE(is_open(assigned));
  EXPECT_FALSE(second);
}

TEST(FileDescriptor, AReleasedDescriptor_StaysOpen) {
  int number = -1;
  {
    FileDescriptor descriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    number = descriptor.release();
  }
  EXPECT_TRUE(is_open(number));
  ::close(number);
}

}  // namespace
}  // namespace ddssec
