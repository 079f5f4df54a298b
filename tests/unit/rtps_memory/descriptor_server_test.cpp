#include "rtps/memory/descriptor_server.hpp"

#include <array>
#include <chrono>
#include <fcntl.h>
#include <memory>
#include <optional>
#include <poll.h>
#include <string>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/bytes.hpp"
#include "tests/unit/rtps_memory/hostile_sockets.hpp"

namespace ddssec::rtps::memory {
namespace {

using namespace testing;

constexpr MonotonicTime kStart = std::chrono::seconds(5);
constexpr std::uint64_t kSegmentId = 7;

DescriptorOffer copy_of(const DescriptorOffer& offer) {
  return {.name = offer.name,
          .token = offer.token.clone(),
          .process = offer.process,
          .segment = offer.segment,
          .memory = offer.memory};
}

// Returns the octets that the server sent; 0 if it closed the connection, -1 if it sends nothing.
ssize_t answer_on(const FileDescriptor& socket) {
  std::array<char, 64> octets{};
  return ::recv(socket.number(), octets.data(), octets.size(), MSG_DONTWAIT);
}

class DescriptorServerTest : public ::testing::Test {
 protected:
  DescriptorOffer offer() {
    auto out = server_.offer(segment_, random_, kStart);
    EXPECT_TRUE(out.has_value());
    return *std::move(out);
  }
  // Returns the result of a request for the offer.
  MemoryResult<std::optional<MappedSegment>> fetch(const DescriptorOffer& offer,
                                                   MonotonicTime now = kStart) {
    auto request = DescriptorRequest::send(offer);
    if (!request) return refuse(request.error());
    server_.offers().forget_late(now);
    server_.serve(now);
    return request->take();
  }
  MemoryRefusal refusal_of(const DescriptorOffer& offer, MonotonicTime now = kStart) {
    auto out = fetch(offer, now);
    EXPECT_FALSE(out.has_value());
    return out ? MemoryRefusal::full : out.error();
  }

  bool is_readable() const {
    std::vector<pollfd> waiting;
    server_.watch(waiting);
    return ::poll(waiting.data(), waiting.size(), 0) > 0;
  }

  SystemRandom random_;
  Segment segment_ = *Segment::make(kSegmentId, 1000, 4);
  DescriptorServer server_ = *DescriptorServer::listen(random_);
};

TEST_F(DescriptorServerTest, Offer_Fetched_GivesTheSegment) {
  const auto reference = *segment_.store(Bytes(100, 0x5a));
  auto fetched = fetch(offer());
  ASSERT_TRUE(fetched.has_value());
  ASSERT_TRUE(fetched->has_value());
  Bytes out(100);
  EXPECT_TRUE((*fetched)->copy(reference, out).has_value());
  EXPECT_EQ(out, Bytes(100, 0x5a));
  EXPECT_EQ(server_.offers().size(), 0U);
  EXPECT_EQ(server_.connections(), 0U);
}

TEST_F(DescriptorServerTest, Answer_NotThereYet_IsNothing) {
  const auto made = offer();
  auto request = DescriptorRequest::send(made);
  ASSERT_TRUE(request.has_value());
  auto early = request->take();
  ASSERT_TRUE(early.has_value());
  EXPECT_FALSE(early->has_value());
  server_.serve(kStart);
  EXPECT_TRUE(request->take()->has_value());
}

TEST_F(DescriptorServerTest, Token_ShownTwice_WorksOnce) {
  const auto made = offer();
  EXPECT_TRUE(fetch(made).has_value());
  EXPECT_EQ(refusal_of(made), MemoryRefusal::no_answer);
}

TEST_F(DescriptorServerTest, Token_WithAWrongBit_IsRefused) {
  const auto made = offer();
  for (std::size_t at = 0; at < 32; ++at) {
    auto wrong = copy_of(made);
    wrong.token.expose([&](BytesView octets) {
      Bytes changed = to_bytes(octets);
      changed[at] ^= 1U;
      wrong.token = *Token::copy_of(changed);
    });
    EXPECT_EQ(refusal_of(wrong), MemoryRefusal::no_answer) << at;
  }
  EXPECT_TRUE(fetch(made).has_value()) << "wrong tokens do not use up the right one";
}

TEST_F(DescriptorServerTest, Token_OfAnotherLength_IsRefused) {
  const auto made = offer();
  const Bytes token = made.token.expose([](BytesView octets) { return to_bytes(octets); });
  for (const std::size_t size : {1U, 31U, 33U, 1000U}) {
    const auto socket = connected(made.name);
    Bytes sent = token;
    sent.resize(size);
    ASSERT_EQ(::send(socket.number(), sent.data(), sent.size(), MSG_NOSIGNAL),
              static_cast<ssize_t>(size));
    server_.serve(kStart);
    EXPECT_EQ(answer_on(socket), 0) << size;
  }
  EXPECT_EQ(server_.offers().size(), 1U);
}

TEST_F(DescriptorServerTest, Offer_AfterItsLifetime_IsRefused) {
  const auto made = offer();
  EXPECT_EQ(server_.offers().next_end(), kStart + OpenOffers::kLifetime);
  EXPECT_EQ(refusal_of(made, kStart + OpenOffers::kLifetime), MemoryRefusal::no_answer);
  EXPECT_EQ(server_.offers().size(), 0U);
}

TEST_F(DescriptorServerTest, Offer_Withdrawn_IsRefused) {
  const auto made = offer();
  server_.offers().withdraw(kSegmentId + 1);
  EXPECT_EQ(server_.offers().size(), 1U);
  server_.offers().withdraw(kSegmentId);
  EXPECT_EQ(refusal_of(made), MemoryRefusal::no_answer);
}

TEST_F(DescriptorServerTest, Offers_AboveTheLimit_AreRefusedUntilSomeExpire) {
  const auto offered_to = [&](std::size_t identity, MonotonicTime now) {
    return server_.offer(segment_, random_, now, std::to_string(identity));
  };
  for (std::size_t i = 0; i < OpenOffers::kMax; ++i) EXPECT_TRUE(offered_to(i, kStart));
  EXPECT_EQ(offered_to(100, kStart).error(), MemoryRefusal::too_many_tokens);
  EXPECT_TRUE(offered_to(100, kStart + OpenOffers::kLifetime));
}

TEST_F(DescriptorServerTest, Offers_OfOneIdentity_LeaveRoomForOthers) {
  std::size_t made = 0;
  for (std::size_t i = 0; i < OpenOffers::kMax; ++i)
    made += server_.offer(segment_, random_, kStart, "CN=carol") ? 1 : 0;
  EXPECT_EQ(made, OpenOffers::kMaxOfOne);
  EXPECT_TRUE(server_.offer(segment_, random_, kStart, "CN=bob"));
}

TEST_F(DescriptorServerTest, Connection_ThatSaysNothing_IsClosedAfterABound) {
  const auto socket = connected(offer().name);
  server_.serve(kStart);
  EXPECT_EQ(server_.connections(), 1U);
  EXPECT_EQ(server_.deadline(), kStart + DescriptorServer::kSilence);
  server_.serve(kStart + DescriptorServer::kSilence);
  EXPECT_EQ(server_.connections(), 0U);
  EXPECT_EQ(answer_on(socket), 0);
}

TEST_F(DescriptorServerTest, Connection_ThatSaysNothing_LearnsNothing) {
  const auto socket = connected(offer().name);
  EXPECT_TRUE(fetch(offer()).has_value());
  EXPECT_EQ(answer_on(socket), -1);
}

TEST_F(DescriptorServerTest, Flood_OfSilentConnections_KeepsNoReaderOut) {
  const auto made = offer();
  std::vector<FileDescriptor> silent;
  for (int i = 0; i < 200; ++i) {
    silent.push_back(connected(made.name));
    server_.serve(kStart);
    EXPECT_LE(server_.connections(), DescriptorServer::kMaxConnections);
  }
  EXPECT_TRUE(fetch(made).has_value());
}

TEST_F(DescriptorServerTest, Connection_ClosedByTheOtherSide_IsForgotten) {
  const auto name = offer().name;
  {
    const auto socket = connected(name);
    server_.serve(kStart);
    EXPECT_EQ(server_.connections(), 1U);
  }
  server_.serve(kStart);
  EXPECT_EQ(server_.connections(), 0U);
}

TEST_F(DescriptorServerTest, Process_OtherThanTheOffered_GetsNoToken) {
  auto made = offer();
  made.process = ::getppid();
  EXPECT_EQ(refusal_of(made), MemoryRefusal::wrong_process);
  made.process = 0;  // the id of a process of another PID namespace
  EXPECT_EQ(refusal_of(made), MemoryRefusal::wrong_process);
}

TEST_F(DescriptorServerTest, Socket_ThatIsNotThere_IsRefused) {
  auto made = offer();
  made.name[0] ^= 1U;
  EXPECT_EQ(refusal_of(made), MemoryRefusal::no_socket);
}

TEST_F(DescriptorServerTest, Memory_OtherThanTheOffered_IsRefused) {
  auto made = offer();
  ++made.memory.inode;
  EXPECT_EQ(refusal_of(made), MemoryRefusal::other_memory);
}

TEST_F(DescriptorServerTest, ExhaustedDescriptors_PauseTheServer) {
  const auto made = offer();
  auto request = DescriptorRequest::send(made);
  ASSERT_TRUE(request.has_value());
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{.rlim_cur = 0, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  server_.serve(kStart);
  EXPECT_EQ(server_.offer(segment_, random_, kStart).error(), MemoryRefusal::no_memory);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  // The waiting connection does not wake the caller before its deadline.
  EXPECT_FALSE(is_readable());
  EXPECT_EQ(server_.deadline(), kStart + std::chrono::seconds(1));
  server_.serve(kStart + std::chrono::seconds(1));
  EXPECT_TRUE(request->take()->has_value());
}

TEST_F(DescriptorServerTest, Server_Waiting_IsReadableWhenAReaderConnects) {
  const auto made = offer();
  EXPECT_FALSE(is_readable());
  const auto socket = connected(made.name);
  EXPECT_TRUE(is_readable());
  server_.serve(kStart);
  EXPECT_FALSE(is_readable());
}

// ---- strangers that send descriptors

TEST_F(DescriptorServerTest, SlowDescriptorOfAStranger_DelaysNoPeer) {
  const auto made = offer();
  SlowToClose hostile;
  {
    const auto stranger = connected(made.name);
    hostile.send_over(stranger);
  }
  expect_quick([&] {
    server_.serve(kStart);
    EXPECT_TRUE(fetch(made).has_value());
  });
}

// SOCK_SEQPACKET has empty messages, which look like the end of the connection.
TEST_F(DescriptorServerTest, SlowDescriptorAfterEmptyMessages_DelaysNoPeer) {
  const auto made = offer();
  for (const int count : {1, 2, 5}) {
    const auto stranger = connected(made.name);
    for (int i = 0; i < count; ++i) EXPECT_EQ(::send(stranger.number(), "", 0, 0), 0);
    SlowToClose hostile;
    hostile.send_over(stranger);
    expect_quick([&] {
      for (int i = 0; i < 3; ++i) server_.serve(kStart);
    });
    EXPECT_EQ(server_.connections(), 0U);
  }
}

// The other side leaves what we sent unread, so its socket reports an error before its messages.
TEST_F(DescriptorServerTest, SlowDescriptorAfterAnError_DelaysNoPeer) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()), 0);
  SlowToClose hostile;
  std::optional<UntrustedSocket> ours;
  ours.emplace(FileDescriptor(ends[0]));
  {
    const FileDescriptor theirs(ends[1]);
    EXPECT_EQ(::send(ends[0], "x", 1, 0), 1);
    hostile.send_over(theirs);
  }
  expect_quick([&] { ours.reset(); });
}

TEST_F(DescriptorServerTest, SlowDescriptorThatAStrangerSendsLater_DelaysNoPeer) {
  const auto made = offer();
  const auto stranger = connected(made.name);
  server_.serve(kStart);
  SlowToClose hostile;
  hostile.send_over(stranger);
  expect_quick([&] { server_.serve(kStart); });
  EXPECT_EQ(server_.connections(), 0U);
}

TEST_F(DescriptorServerTest, SlowDescriptorAfterTheToken_DelaysNoPeer) {
  const auto made = offer();
  const auto reader = connected(made.name);
  made.token.expose([&](BytesView token) {
    EXPECT_EQ(::send(reader.number(), token.data(), token.size(), 0), 32);
  });
  SlowToClose hostile;
  hostile.send_over(reader);
  expect_quick([&] { server_.serve(kStart); });
  EXPECT_EQ(server_.offers().size(), 0U);
}

TEST_F(DescriptorServerTest, SlowDescriptorOfAConnectionThatIsTooLate_DelaysNoPeer) {
  const auto stranger = connected(offer().name);
  server_.serve(kStart);
  SlowToClose hostile;
  hostile.send_over(stranger);
  expect_quick([&] { server_.serve(kStart + DescriptorServer::kSilence); });
}

TEST_F(DescriptorServerTest, ServerThatEndsWithSlowDescriptorsWaiting_DelaysNoPeer) {
  SlowToClose hostile;
  std::optional<DescriptorServer> server(*DescriptorServer::listen(random_));
  const auto made = server->offer(segment_, random_, kStart);
  const auto stranger = connected(made->name);
  hostile.send_over(stranger);
  expect_quick([&] { server.reset(); });
}

TEST_F(DescriptorServerTest, SlowDescriptors_Many_ServerTakesNoMoreUntilTheyAreClosed) {
  const auto made = offer();
  const auto other = offer();
  std::vector<std::unique_ptr<SlowToClose>> hostile;
  for (int i = 0; i < 20; ++i) {
    const auto& one = hostile.emplace_back(std::make_unique<SlowToClose>());
    const auto stranger = connected(made.name);
    ASSERT_TRUE(stranger);
    one->send_over(stranger);
    expect_quick([&] { server_.serve(kStart); });
  }
  EXPECT_TRUE(closes_too_many());
  EXPECT_FALSE(is_readable()) << "it pauses";
  EXPECT_EQ(DescriptorRequest::send(made).error(), MemoryRefusal::held_up);
  hostile.clear();
  auto now = kStart;
  for (int i = 0; i < 4; ++i) {  // those that wait to be accepted
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    server_.serve(now += std::chrono::seconds(1));
  }
  EXPECT_TRUE(fetch(other, now).has_value());
}

// ---- strangers of other users, and shares

// Shows the token as a process of another user. True if a descriptor arrives.
bool gets_descriptor(const DescriptorOffer& made, DescriptorServer& server) {
  std::array<int, 2> ends{};
  EXPECT_EQ(::pipe(ends.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    if (::setresuid(65534, 65534, 65534) != 0) ::_exit(3);
    auto request = DescriptorRequest::send(made, Users::any);
    if (::write(ends[1], "x", 1) != 1 || !request) ::_exit(3);
    pollfd waiting{.fd = request->descriptor(), .events = POLLIN, .revents = 0};
    ::poll(&waiting, 1, 5000);
    const auto taken = request->take();
    ::_exit(taken && *taken ? 0 : 1);
  }
  char octet = 0;
  EXPECT_EQ(::read(ends[0], &octet, 1), 1);
  for (const int end : ends) ::close(end);
  server.serve(kStart);
  int status = -1;
  EXPECT_EQ(::waitpid(child, &status, 0), child);
  return status == 0;
}

TEST_F(DescriptorServerTest, OtherUser_IsRefusedAlsoWithTheToken) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root";
  EXPECT_FALSE(gets_descriptor(offer(), server_));
}

TEST_F(DescriptorServerTest, OtherUser_Admitted_GetsTheDescriptor) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root";
  server_ = *DescriptorServer::listen(random_, Users::any);
  EXPECT_TRUE(gets_descriptor(offer(), server_));
}

TEST_F(DescriptorServerTest, OneProcess_HoldsFewConnections) {
  const auto made = offer();
  std::vector<FileDescriptor> silent;
  for (int i = 0; i < 10; ++i) silent.push_back(connected(made.name));
  server_.serve(kStart);
  EXPECT_EQ(server_.connections(), DescriptorServer::kMaxOfOne);
  EXPECT_EQ(answer_on(silent.front()), 0) << "the oldest one leaves";
  EXPECT_EQ(answer_on(silent.back()), -1);
}

}  // namespace
}  // namespace ddssec::rtps::memory
