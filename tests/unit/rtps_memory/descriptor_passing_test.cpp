// The thread that passes descriptors on: what it does, and that no other thread waits for it.
#include "rtps/memory/descriptor_passing.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <sys/resource.h>
#include <sys/wait.h>

#include "tests/unit/rtps_memory/hostile_sockets.hpp"

namespace ddssec::rtps::memory {
namespace {

using namespace testing;
using namespace std::chrono_literals;

constexpr MonotonicTime kStart = 5s;

MonotonicTime real_now() { return std::chrono::steady_clock::now().time_since_epoch(); }

bool until(const std::function<bool()>& done) {
  for (const auto end = real_now() + 5s; real_now() < end; std::this_thread::sleep_for(1ms))
    if (done()) return true;
  return done();
}

struct Passing {
  Passing() { EXPECT_TRUE(it->start()); }
  std::optional<DescriptorPassing::FetchedSegment> next_fetched() {
    std::vector<DescriptorPassing::FetchedSegment> all;
    until([&] { return !(all = it->take_fetched()).empty(); });
    return all.empty() ? std::nullopt : std::optional(std::move(all[0]));
  }
  std::optional<DescriptorPassing::PreparedSlots> next_prepared() {
    std::vector<DescriptorPassing::PreparedSlots> all;
    until([&] { return !(all = it->take_prepared()).empty(); });
    return all.empty() ? std::nullopt : std::optional(std::move(all[0]));
  }
  SystemRandom random;
  std::unique_ptr<DescriptorPassing> it = *DescriptorPassing::make(random);
};

TEST(DescriptorPassing, Fetch_GivesTheSegment) {
  Passing writer, reader;
  auto segment = *Segment::make(7, 1000, 4);
  const auto reference = *segment.store(Bytes(100, 0x5a));
  const auto id = reader.it->fetch(*writer.it->offer(segment, writer.random, kStart));
  ASSERT_TRUE(id.has_value());
  const auto fetched = reader.next_fetched();
  ASSERT_TRUE(fetched && fetched->segment);
  EXPECT_EQ(fetched->id, *id);
  Bytes out(100);
  EXPECT_TRUE(fetched->segment->copy(reference, out).has_value());
  EXPECT_EQ(out, Bytes(100, 0x5a));
}

TEST(DescriptorPassing, Result_MakesTheDescriptorReadable) {
  Passing passing;
  pollfd waiting{.fd = passing.it->descriptor(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(::poll(&waiting, 1, 0), 0);
  ASSERT_TRUE(passing.it->make_slots(9, 10'000).has_value());
  EXPECT_EQ(::poll(&waiting, 1, 5000), 1);
  passing.it->serve(kStart);
  EXPECT_EQ(::poll(&waiting, 1, 0), 0);
  EXPECT_TRUE(passing.next_prepared()->slots.has_value());
}

TEST(DescriptorPassing, SilentProcess_AnswerComesInTime) {
  Passing passing;
  Impostor impostor;
  ASSERT_TRUE(passing.it->fetch(std::move(impostor.offer)).has_value());
  const auto fetched = passing.next_fetched();
  ASSERT_TRUE(fetched);
  EXPECT_EQ(fetched->segment.error(), MemoryRefusal::no_answer);
}

TEST(DescriptorPassing, ManySilentProcesses_OwnMemoryIsMadeMeanwhile) {
  Passing passing;
  std::vector<std::unique_ptr<Impostor>> impostors;
  for (int i = 0; i < 40; ++i) {
    impostors.push_back(std::make_unique<Impostor>());
    ASSERT_TRUE(passing.it->fetch(std::move(impostors.back()->offer)).has_value());
  }
  const auto begin = real_now();
  ASSERT_TRUE(passing.it->make_slots(9, 10'000).has_value());
  const auto prepared = passing.next_prepared();
  EXPECT_TRUE(prepared && prepared->slots);
  EXPECT_LT(real_now() - begin, DescriptorPassing::kMaxRequest);
}

TEST(DescriptorPassing, Wiped_NothingIsLeft) {
  Passing passing;
  auto slots = *SampleSlots::make(9, 10'000);
  std::ranges::fill(*slots.begin({1}, kStart), std::uint8_t{0x5a});
  const auto reference = slots.end({1}, 10'000, kStart);
  const auto reader =
      *MappedSegment::map(slots.segment().for_reader(), 9, slots.segment().memory());
  ASSERT_TRUE(reader.check(reference).has_value());
  passing.it->wipe(std::move(slots));
  const auto prepared = passing.next_prepared();
  ASSERT_TRUE(prepared && prepared->slots);
  EXPECT_EQ(reader.check(reference).error(), MemoryRefusal::gone);
  // A reference with the right generation finds only zeros.
  auto again = reference;
  again.generation += 4;  // it was freed and wiped
  Bytes out(10'000, 1);
  while (!reader.check(again) && again.generation < 100) again.generation += 2;
  (void)reader.copy(again, out);
  EXPECT_EQ(std::ranges::count(out, 0x5a), 0);
}

TEST(DescriptorPassing, MuchWork_IsRefused) {
  Passing passing;
  std::size_t taken = 0;
  for (std::size_t i = 0; i < 2 * DescriptorPassing::kMaxWork; ++i)
    taken += passing.it->make_slots(i, 100).has_value() ? 1 : 0;
  EXPECT_EQ(taken, DescriptorPassing::kMaxWork);
  std::size_t done = 0;
  EXPECT_TRUE(until([&] { return (done += passing.it->take_prepared().size()) == taken; }));
  EXPECT_TRUE(passing.it->accepts_work());
}

TEST(DescriptorPassing, StrangerSendsASlowDescriptor_ReadersAreStillServed) {
  Passing writer, reader;
  const auto segment = *Segment::make(7, 1000, 4);
  auto offer = *writer.it->offer(segment, writer.random, kStart);
  SlowToClose hostile;
  {
    const auto stranger = connected(offer.name);
    hostile.send_over(stranger);
  }
  ASSERT_TRUE(reader.it->fetch(std::move(offer)).has_value());
  const auto fetched = reader.next_fetched();
  EXPECT_TRUE(fetched && fetched->segment);
}

// A passing whose thread waits for a socket that lingers. No descriptor number was left for the
// socket, so the system itself dropped it.
struct HeldUp {
  HeldUp() {
    EXPECT_TRUE(passing.it->fetch(std::move(impostor.offer)).has_value());
    rlimit before{};
    EXPECT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
    impostor.socket =
        FileDescriptor(::accept4(impostor.listener.number(), nullptr, nullptr, SOCK_CLOEXEC));
    const rlimit none{.rlim_cur = 0, .rlim_max = before.rlim_max};
    EXPECT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
    is_held = hostile.send_over(impostor.socket);
    std::this_thread::sleep_for(100ms);
    EXPECT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
    EXPECT_TRUE(!is_held || until([&] { return !passing.it->accepts_work(); }));
  }
  bool is_held = false;
  SlowToClose hostile;
  Impostor impostor;
  Passing passing;
};

// Tries until the thread is the last one that has the descriptor.
std::unique_ptr<HeldUp> held_up() {
  auto held = std::make_unique<HeldUp>();
  while (!held->is_held) held = std::make_unique<HeldUp>();
  return held;
}

TEST(DescriptorPassing, ThreadIsHeldUp_NoCallWaits) {
  const auto held = held_up();
  const auto segment = *Segment::make(7, 1000, 4);
  const auto before = real_now();
  EXPECT_EQ(held->passing.it->offer(segment, held->passing.random, kStart).error(),
            MemoryRefusal::held_up);
  EXPECT_EQ(held->passing.it->make_slots(1, 100).error(), MemoryRefusal::held_up);
  EXPECT_EQ(held->passing.it->fetch({.token = *Token::copy_of(Bytes(32))}).error(),
            MemoryRefusal::held_up);
  held->passing.it->serve(kStart);
  EXPECT_LT(real_now() - before, 500ms);
}

TEST(DescriptorPassing, ThreadIsHeldUp_EndDoesNotWait) {
  const auto held = held_up();
  const auto before = real_now();
  held->passing.it.reset();
  EXPECT_LT(real_now() - before, 1s);
}

TEST(DescriptorPassing, ThreadIsNoLongerHeldUp_WorkIsTakenAgain) {
  const auto held = held_up();
  { const FileDescriptor reset(held->hostile.other.release()); }
  EXPECT_TRUE(until([&] { return held->passing.it->accepts_work(); }));
}

TEST(DescriptorPassing, End_IsQuick) {
  const auto before = real_now();
  for (int i = 0; i < 20; ++i) Passing passing;
  EXPECT_LT(real_now() - before, 2s);
}

// A child has no such thread, and must not wait for it for ever.
TEST(DescriptorPassing, ChildOfFork_Ends) {
  Passing passing;
  const pid_t child = ::fork();
  if (child == 0) {
    passing.it.reset();
    ::_exit(0);
  }
  EXPECT_TRUE(until([&] { return ::waitpid(child, nullptr, WNOHANG) == child; }));
}

}  // namespace
}  // namespace ddssec::rtps::memory
