// Requests for descriptors between processes, with descriptors that are slow to close.
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <iterator>
#include <optional>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/bytes.hpp"
#include "rtps/memory/descriptor_server.hpp"
#include "tests/unit/rtps_memory/hostile_sockets.hpp"

namespace ddssec::rtps::memory {
namespace {

using namespace testing;

constexpr MonotonicTime kStart = std::chrono::seconds(5);
constexpr std::uint64_t kSegmentId = 7;

// Returns the result of an answer with these descriptors.
MemoryResult<std::optional<MappedSegment>> answered_with(const std::vector<int>& descriptors,
                                                         MemoryId memory) {
  Impostor impostor(memory);
  auto request = DescriptorRequest::send(impostor.offer);
  EXPECT_TRUE(request.has_value());
  impostor.answer(descriptors);
  return request->take();
}

// Returns how many descriptors are open, because a leaked one may have any number.
std::ptrdiff_t open_descriptors() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

TEST(DescriptorRequestTest, Answer_WithoutOrWithTwoDescriptors_IsRefused) {
  const auto segment = *Segment::make(kSegmentId, 64, 1);
  const int number = segment.descriptor();
  const auto before = open_descriptors();
  EXPECT_TRUE(answered_with({number}, segment.memory()).has_value());
  EXPECT_EQ(answered_with({}, segment.memory()).error(), MemoryRefusal::no_answer);
  EXPECT_EQ(answered_with({number, number}, segment.memory()).error(), MemoryRefusal::no_answer);
  EXPECT_EQ(answered_with(std::vector<int>(20, number), segment.memory()).error(),
            MemoryRefusal::no_answer);
  EXPECT_EQ(open_descriptors(), before) << "no descriptor leaks";
}

TEST(DescriptorRequestTest, Answer_WithADescriptorOfAnotherKind_IsRefused) {
  const FileDescriptor null(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  EXPECT_EQ(answered_with({null.number()}, {}).error(), MemoryRefusal::wrong_kind);
}

// A relay in another network namespace puts memory of its own in the place of the writer's.
TEST(DescriptorRequestTest, Answer_WithSealedMemoryOfARelay_IsRefused) {
  const auto writers = *Segment::make(kSegmentId, 64, 1);
  const auto relays = *Segment::make(kSegmentId, 64, 1);
  EXPECT_EQ(answered_with({relays.descriptor()}, writers.memory()).error(),
            MemoryRefusal::other_memory);
}

TEST(DescriptorRequestTest, Writer_KilledBeforeItAnswers_IsNoticed) {
  SystemRandom random;
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const FileDescriptor in(ends[0]);
  const FileDescriptor out(ends[1]);
  const pid_t child = ::fork();
  if (child == 0) {
    auto server = DescriptorServer::listen(random);
    auto segment = Segment::make(kSegmentId, 64, 1);
    const auto offer = server->offer(*segment, random, kStart);
    if (::write(out.number(), offer->name.data(), offer->name.size()) < 0) ::_exit(1);
    for (;;) ::pause();
  }
  SocketName name{};
  ASSERT_EQ(::read(in.number(), name.data(), name.size()), static_cast<ssize_t>(name.size()));
  auto request = DescriptorRequest::send({.name = name,
                                          .token = *Token::copy_of(Bytes(32)),
                                          .process = child,
                                          .segment = kSegmentId,
                                          .memory = {}});
  ASSERT_TRUE(request.has_value());
  EXPECT_FALSE(request->take()->has_value());
  ASSERT_EQ(::kill(child, SIGKILL), 0);
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  const auto answer = request->take();
  ASSERT_FALSE(answer.has_value());
  EXPECT_EQ(answer.error(), MemoryRefusal::no_answer);
  EXPECT_FALSE(connected(name)) << "the name is gone with the process";
}

TEST(DescriptorRequestTest, DescriptorThatIsSlowToClose_DelaysNoOtherRequest) {
  Impostor impostor;
  auto request = DescriptorRequest::send(impostor.offer);
  ASSERT_TRUE(request.has_value());
  SlowToClose hostile;
  impostor.answer({hostile.slow.number()});
  ::close(hostile.slow.release());
  expect_quick([&] { EXPECT_EQ(request->take().error(), MemoryRefusal::wrong_kind); });
}

TEST(DescriptorRequestTest, SlowDescriptorBesideAGoodOne_DelaysNoOtherRequest) {
  const auto segment = *Segment::make(kSegmentId, 64, 1);
  Impostor impostor(segment.memory());
  auto request = DescriptorRequest::send(impostor.offer);
  ASSERT_TRUE(request.has_value());
  SlowToClose hostile;
  impostor.answer({segment.descriptor(), hostile.slow.number()});
  ::close(hostile.slow.release());
  expect_quick([&] { EXPECT_EQ(request->take().error(), MemoryRefusal::wrong_kind); });
}

TEST(DescriptorRequestTest, SlowDescriptorAfterTheAnswer_DelaysNoOtherRequest) {
  const auto segment = *Segment::make(kSegmentId, 64, 1);
  Impostor impostor(segment.memory());
  auto request = DescriptorRequest::send(impostor.offer);
  ASSERT_TRUE(request.has_value());
  SlowToClose hostile;
  impostor.answer({segment.descriptor()});
  hostile.send_over(impostor.socket);
  expect_quick([&] {
    EXPECT_TRUE(request->take().has_value());
    const auto last = *std::move(request);
  });
}

}  // namespace
}  // namespace ddssec::rtps::memory
