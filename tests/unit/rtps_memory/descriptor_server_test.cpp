#include "rtps/memory/descriptor_server.hpp"

#include <array>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <iterator>
#include <netinet/in.h>
#include <poll.h>
#include <string>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/bytes.hpp"

namespace ddssec::rtps::memory {
namespace {

constexpr MonotonicTime kStart = std::chrono::seconds(5);
constexpr std::uint64_t kSegmentId = 7;

Offer copy_of(const Offer& offer) {
  return {.name = offer.name,
          .token = offer.token.clone(),
          .process = offer.process,
          .segment = offer.segment,
          .memory = offer.memory};
}

/// A socket that is connected to `name` (SOCK_SEQPACKET), as an outsider opens it.
Descriptor connected(const SocketName& name) {
  Descriptor out(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const std::string text = "ddssec-" + to_hex(name);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, text.data(), text.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  if (::connect(out.number(), static_cast<const sockaddr*>(static_cast<const void*>(&address)),
                size) != 0)
    return Descriptor();
  return out;
}

/// Octets that the server sent; 0 if it closed the connection, -1 if it says nothing.
ssize_t answer_on(const Descriptor& socket) {
  std::array<char, 64> octets{};
  return ::recv(socket.number(), octets.data(), octets.size(), MSG_DONTWAIT);
}

class DescriptorServerTest : public ::testing::Test {
 protected:
  Offer offer() {
    auto out = server_.offer(segment_, random_, kStart);
    EXPECT_TRUE(out.has_value());
    return *std::move(out);
  }
  /// What a request for the offer ends with.
  Outcome<std::optional<MappedSegment>> fetch(const Offer& offer, MonotonicTime now = kStart) {
    auto request = DescriptorRequest::send(offer);
    if (!request) return refuse(request.error());
    server_.serve(now);
    return request->take();
  }
  Refusal refusal_of(const Offer& offer, MonotonicTime now = kStart) {
    auto out = fetch(offer, now);
    EXPECT_FALSE(out.has_value());
    return out ? Refusal::full : out.error();
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
  EXPECT_EQ(server_.offers(), 0U);
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
  EXPECT_EQ(refusal_of(made), Refusal::no_answer);
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
    EXPECT_EQ(refusal_of(wrong), Refusal::no_answer) << at;
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
  EXPECT_EQ(server_.offers(), 1U);
}

TEST_F(DescriptorServerTest, Offer_AfterItsLifetime_IsRefused) {
  const auto made = offer();
  EXPECT_EQ(server_.deadline(), kStart + DescriptorServer::kOfferLifetime);
  EXPECT_EQ(refusal_of(made, kStart + DescriptorServer::kOfferLifetime), Refusal::no_answer);
  EXPECT_EQ(server_.offers(), 0U);
}

TEST_F(DescriptorServerTest, Offer_Withdrawn_IsRefused) {
  const auto made = offer();
  server_.withdraw(kSegmentId + 1);
  EXPECT_EQ(server_.offers(), 1U);
  server_.withdraw(kSegmentId);
  EXPECT_EQ(refusal_of(made), Refusal::no_answer);
}

TEST_F(DescriptorServerTest, Offers_AboveTheLimit_AreRefusedUntilSomeExpire) {
  for (std::size_t i = 0; i < DescriptorServer::kMaxOffers; ++i) offer();
  EXPECT_EQ(server_.offer(segment_, random_, kStart).error(), Refusal::too_many_tokens);
  EXPECT_TRUE(
      server_.offer(segment_, random_, kStart + DescriptorServer::kOfferLifetime).has_value());
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
  std::vector<Descriptor> silent;
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
  EXPECT_EQ(refusal_of(made), Refusal::wrong_process);
  made.process = 0;  // what a process of another PID namespace looks like
  EXPECT_EQ(refusal_of(made), Refusal::wrong_process);
}

TEST_F(DescriptorServerTest, Socket_ThatIsNotThere_IsRefused) {
  auto made = offer();
  made.name[0] ^= 1U;
  EXPECT_EQ(refusal_of(made), Refusal::no_socket);
}

TEST_F(DescriptorServerTest, Memory_OtherThanTheOffered_IsRefused) {
  auto made = offer();
  ++made.memory.inode;
  EXPECT_EQ(refusal_of(made), Refusal::other_memory);
}

TEST_F(DescriptorServerTest, Descriptors_Exhausted_PauseTheServer) {
  const auto made = offer();
  auto request = DescriptorRequest::send(made);
  ASSERT_TRUE(request.has_value());
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{.rlim_cur = 0, .rlim_max = before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  server_.serve(kStart);
  EXPECT_EQ(server_.offer(segment_, random_, kStart).error(), Refusal::no_memory);
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  // The waiting connection does not wake the caller meanwhile.
  pollfd waiting{.fd = server_.descriptor(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&waiting, 1, 0), 0);
  EXPECT_EQ(server_.deadline(), kStart + std::chrono::seconds(1));
  server_.serve(kStart + std::chrono::seconds(1));
  EXPECT_TRUE(request->take()->has_value());
}

TEST_F(DescriptorServerTest, Server_Waiting_IsReadableWhenAReaderConnects) {
  const auto made = offer();
  pollfd waiting{.fd = server_.descriptor(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&waiting, 1, 0), 0);
  const auto socket = connected(made.name);
  EXPECT_EQ(::poll(&waiting, 1, 0), 1);
  server_.serve(kStart);
  EXPECT_EQ(::poll(&waiting, 1, 0), 0);
}

/// What a hostile server answers, with these descriptors.
Outcome<std::optional<MappedSegment>> answered_with(const std::vector<int>& descriptors,
                                                    MemoryId memory) {
  SystemRandom random;
  SocketName name{};
  EXPECT_TRUE(random.fill(name).has_value());
  const Descriptor listener(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  const std::string text = "ddssec-" + to_hex(name);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, text.data(), text.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  EXPECT_EQ(::bind(listener.number(),
                   static_cast<const sockaddr*>(static_cast<const void*>(&address)), size),
            0);
  EXPECT_EQ(::listen(listener.number(), 1), 0);
  Offer offer{.name = name,
              .token = *Token::copy_of(Bytes(32)),
              .process = ::getpid(),
              .segment = kSegmentId,
              .memory = memory};
  auto request = DescriptorRequest::send(offer);
  EXPECT_TRUE(request.has_value());
  const Descriptor socket(::accept(listener.number(), nullptr, nullptr));
  std::array<char, 256> control{};
  char octet = 1;
  iovec part{.iov_base = &octet, .iov_len = 1};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  if (!descriptors.empty()) {
    const auto octets = descriptors.size() * sizeof(int);
    message.msg_control = control.data();
    message.msg_controllen = CMSG_SPACE(octets);
    cmsghdr* const head = CMSG_FIRSTHDR(&message);
    head->cmsg_level = SOL_SOCKET;
    head->cmsg_type = SCM_RIGHTS;
    head->cmsg_len = CMSG_LEN(octets);
    std::memcpy(CMSG_DATA(head), descriptors.data(), octets);
  }
  EXPECT_EQ(::sendmsg(socket.number(), &message, 0), 1);
  return request->take();
}

/// How many descriptors are open: a leaked one may have any number.
std::ptrdiff_t open_descriptors() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {});
}

TEST(DescriptorRequestTest, Answer_WithoutOrWithTwoDescriptors_IsRefused) {
  const auto segment = *Segment::make(kSegmentId, 64, 1);
  const int number = segment.descriptor();
  const auto before = open_descriptors();
  EXPECT_TRUE(answered_with({number}, segment.memory()).has_value());
  EXPECT_EQ(answered_with({}, segment.memory()).error(), Refusal::no_answer);
  EXPECT_EQ(answered_with({number, number}, segment.memory()).error(), Refusal::no_answer);
  EXPECT_EQ(answered_with(std::vector<int>(20, number), segment.memory()).error(),
            Refusal::no_answer);
  EXPECT_EQ(open_descriptors(), before) << "no descriptor leaks";
}

TEST(DescriptorRequestTest, Answer_WithADescriptorOfAnotherKind_IsRefused) {
  const Descriptor null(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  EXPECT_EQ(answered_with({null.number()}, {}).error(), Refusal::wrong_kind);
}

// A relay in another network namespace, which puts memory of its own in the place of the writer's.
TEST(DescriptorRequestTest, Answer_WithSealedMemoryOfARelay_IsRefused) {
  const auto writers = *Segment::make(kSegmentId, 64, 1);
  const auto relays = *Segment::make(kSegmentId, 64, 1);
  EXPECT_EQ(answered_with({relays.descriptor()}, writers.memory()).error(), Refusal::other_memory);
}

TEST(DescriptorRequestTest, Writer_KilledBeforeItAnswers_IsNoticed) {
  SystemRandom random;
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const Descriptor in(ends[0]);
  const Descriptor out(ends[1]);
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
  EXPECT_EQ(answer.error(), Refusal::no_answer);
  EXPECT_FALSE(connected(name)) << "the name is gone with the process";
}

/// A TCP socket with octets that the other side never takes: its close waits for a minute.
struct SlowToClose {
  SlowToClose() {
    const Descriptor listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    auto* const generic = static_cast<sockaddr*>(static_cast<void*>(&address));
    socklen_t size = sizeof address;
    EXPECT_EQ(::bind(listener.number(), generic, size), 0);
    EXPECT_EQ(::listen(listener.number(), 1), 0);
    EXPECT_EQ(::getsockname(listener.number(), generic, &size), 0);
    slow = Descriptor(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
    EXPECT_EQ(::connect(slow.number(), generic, size), 0);
    other = Descriptor(::accept4(listener.number(), nullptr, nullptr, SOCK_CLOEXEC));
    const linger wait{.l_onoff = 1, .l_linger = 60};
    ::setsockopt(slow.number(), SOL_SOCKET, SO_LINGER, &wait, sizeof wait);
    const Bytes octets(1 << 16);
    while (::send(slow.number(), octets.data(), octets.size(), MSG_DONTWAIT) > 0) {
    }
  }
  Descriptor slow, other;
};

// An impostor in this process, so that its id is the one that the offer names.
TEST_F(DescriptorServerTest, Descriptor_ThatIsSlowToClose_HoldsNobodyUp) {
  auto made = offer();
  made.name.fill(0x77);
  const Descriptor listener(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  const std::string text = "ddssec-" + to_hex(made.name);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path + 1, text.data(), text.size());
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + text.size());
  ASSERT_EQ(::bind(listener.number(), static_cast<sockaddr*>(static_cast<void*>(&address)), size),
            0);
  ASSERT_EQ(::listen(listener.number(), 1), 0);
  auto request = DescriptorRequest::send(made);
  ASSERT_TRUE(request.has_value());
  const Descriptor socket(::accept4(listener.number(), nullptr, nullptr, SOCK_CLOEXEC));
  SlowToClose hostile;
  char octet = 1;
  iovec part{.iov_base = &octet, .iov_len = 1};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  cmsghdr* const head = CMSG_FIRSTHDR(&message);
  head->cmsg_level = SOL_SOCKET;
  head->cmsg_type = SCM_RIGHTS;
  head->cmsg_len = CMSG_LEN(sizeof(int));
  const int number = hostile.slow.number();
  std::memcpy(CMSG_DATA(head), &number, sizeof number);
  ASSERT_EQ(::sendmsg(socket.number(), &message, 0), 1);
  hostile.slow = Descriptor();  // the swap keeps it until the end of the line
  const auto before = std::chrono::steady_clock::now();
  EXPECT_EQ(request->take().error(), Refusal::wrong_kind);
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(5));
}

}  // namespace
}  // namespace ddssec::rtps::memory
