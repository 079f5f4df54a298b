// What is held back of coherent sets and of groups, tested alone.
#include "rtps/dcps/presenter.hpp"

#include <gmock/gmock.h>

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

Guid writer(std::uint8_t n) { return {GuidPrefix::from(Bytes(12, n)), EntityId{{0, 0, 1, 2}}}; }
const Guid kGroup{GuidPrefix::from(Bytes(12, 9)), EntityId{{0, 0, 1, 8}}};

// More small samples of one identity than these are not held.
constexpr auto kMaxSamples = Presenter::kMaxOctets / 2 / Presenter::kPricePerItem;

GuidPrefix identity(std::uint8_t n) { return GuidPrefix::from(Bytes(12, n)); }

struct Reader final : PresentedReader {
  std::vector<std::int64_t>* seen;
  std::size_t room = 100, most = 1000;
  std::size_t lost = 0;
  mutable std::size_t instances = 0;  // those of the last set
  mutable int asked = 0;              // how often the presenter asked for room
  std::optional<int> takes = {};      // it accepts so many more, whatever room_for says
  std::vector<Limit> limits;          // the limits that ended sets
  explicit Reader(std::vector<std::int64_t>& to) : seen(&to) {}
  KeyHash instance_of(const Change& change) const override { return {change.payload.view()[0]}; }
  Room room_for(const WantedRoom& wanted, const Guid&) const override {
    ++asked;
    instances = wanted.instances.size();
    return wanted.samples > most ? Room::never : wanted.samples > room ? Room::later : Room::now;
  }
  bool present(Change& change) override {
    if (takes && (*takes)-- <= 0) return false;
    seen->push_back(change.payload.view()[0]);
    return true;
  }
  std::vector<Guid> gone = {};
  void note_left(const Guid& writer) override { gone.push_back(writer); }
  void note_lost(std::size_t samples) override { lost += samples; }
  void give_up(const Guid&, std::size_t samples, Limit limit) override {
    note_lost(samples);
    limits.push_back(limit);
  }
};

struct Presenting : ::testing::Test {
  std::vector<std::int64_t> seen;
  Reader one{seen}, two{seen};
  MonotonicTime now = std::chrono::seconds(1);

  static Change change(std::uint8_t from, std::int64_t number, std::uint8_t value,
                       CoherentSetInfo coherence) {
    Change out;
    out.writer = writer(from);
    out.sequence_number = {number};
    out.coherence = coherence;
    if (value > 0) out.payload = Payload::copy_of(Bytes{value});
    return out;
  }
  std::vector<std::int64_t> take() { return std::exchange(seen, {}); }
};

struct CoherentSets : Presenting {
  Presenter presenter{Presenter::PresentedAccess{.is_coherent = true}};
  void SetUp() override { presenter.add_writer(one, writer(1), {}, identity(1)); }
  bool put(std::int64_t number, std::uint8_t value, std::int64_t set) {
    auto next = change(1, number, value, {{set}, {}, {}, {}});
    return presenter.on_change(one, next, now);
  }
};

TEST_F(CoherentSets, ASet_EndsWithAMarkerAnotherSetOrNone) {
  put(1, 1, 1), put(2, 2, 1);
  EXPECT_THAT(take(), IsEmpty());
  put(3, 0, 0);
  EXPECT_THAT(take(), ElementsAre(1, 2));
  put(4, 4, 4), put(5, 5, 5);
  EXPECT_THAT(take(), ElementsAre(4));
  put(6, 6, 0);
  EXPECT_THAT(take(), ElementsAre(5, 6));
}

// The writer has been told that the set arrived.
TEST_F(CoherentSets, WhatTheReaderRefusesAfterAll_Waits) {
  one.takes = 1;
  put(1, 1, 1), put(2, 2, 1), put(3, 3, 1), put(4, 0, 0), put(5, 5, 0);
  EXPECT_THAT(take(), ElementsAre(1));
  one.takes = 0;
  presenter.present_ready(now);
  EXPECT_THAT(take(), IsEmpty());
  one.takes.reset();
  presenter.present_ready(now);
  EXPECT_THAT(take(), ElementsAre(2, 3, 5));
  EXPECT_EQ(one.lost, 0u);
  EXPECT_EQ(presenter.octets(), 0u);
}

// Without this bound, each take() of the reader lasted 15 ms while a set of 40,000 samples waited.
TEST_F(CoherentSets, WhatWaits_CostsLittleOfTheReadersTime) {
  one.room = 10, one.most = 10'000;
  constexpr int kMany = 1000;
  for (int i = 1; i <= kMany; ++i) put(i, 1, 1);
  put(kMany + 1, 0, 0);
  const auto before = one.asked;
  for (int i = 0; i < 1000; ++i) presenter.present_ready(now);
  EXPECT_EQ(one.asked, before);
  EXPECT_EQ(presenter.next_tick(), now + kMany * Presenter::kPausePerItem);
  now = presenter.next_tick();
  presenter.present_ready(now, Presenter::ReaderRoom::unchanged);
  EXPECT_EQ(one.asked, before + 1);
  EXPECT_EQ(presenter.next_tick(), kNever) << "nothing was taken meanwhile";
  one.room = 10'000;
  presenter.present_ready(now);
  now = presenter.next_tick();
  presenter.present_ready(now, Presenter::ReaderRoom::unchanged);
  EXPECT_EQ(take().size(), kMany + 0u);
}

TEST_F(CoherentSets, SetsThatWait_HaveTurns) {
  presenter.add_writer(one, writer(2), {}, identity(2));
  presenter.add_writer(one, writer(3), {}, identity(3));
  one.room = 0, one.most = 10'000;
  for (const std::uint8_t from : {1, 2, 3}) {
    const int size = from == 2 ? 400 : 500;
    for (int i = 1; i <= size + 1; ++i) {
      auto next = change(from, i, i > size ? 0 : from, {{i > size ? 0 : 1}, {}, {}, {}});
      ASSERT_TRUE(presenter.on_change(one, next, now));
    }
  }
  one.room = 400;
  presenter.present_ready(now);
  for (int turn = 0; turn < 3; ++turn) {
    now = std::min(presenter.next_tick(), now + std::chrono::seconds(1));
    presenter.present_ready(now, Presenter::ReaderRoom::unchanged);
  }
  EXPECT_EQ(take().size(), 400u) << "the one for which there is room";
}

// The same holds for many sets of few samples, each from a writer of its own.
TEST_F(CoherentSets, ManySetsThatWait_CostLittleOfTheReadersTime) {
  one.room = 0;
  for (std::uint8_t from = 10; from < 250; ++from) {
    presenter.add_writer(one, writer(from), {}, identity(2));
    for (int i = 1; i <= 11; ++i) {
      auto next = change(from, i, i > 10 ? 0 : 7, {{i > 10 ? 0 : 1}, {}, {}, {}});
      ASSERT_TRUE(presenter.on_change(one, next, now));
    }
  }
  const auto before = one.asked;
  for (int i = 0; i < 100; ++i) presenter.present_ready(now);
  EXPECT_LT(one.asked - before, 60);
  one.room = 100;
  for (int turn = 0; turn < 100; ++turn) {
    now += std::chrono::milliseconds(2);
    presenter.present_ready(
        now, turn == 0 ? Presenter::ReaderRoom::may_be_freed : Presenter::ReaderRoom::unchanged);
  }
  EXPECT_EQ(take().size(), 2400u);
}

TEST_F(CoherentSets, WhatWaits_IsKeptWhenItsWriterLeaves) {
  one.takes = 1;
  put(1, 1, 1), put(2, 2, 1), put(3, 3, 1), put(4, 0, 0), put(5, 5, 5);
  EXPECT_TRUE(presenter.remove_writer(one, writer(1), now));
  EXPECT_THAT(take(), ElementsAre(1));
  EXPECT_EQ(one.lost, 1u) << "the set that is open";
  EXPECT_THAT(one.gone, IsEmpty());
  one.takes.reset();
  presenter.present_ready(now);
  EXPECT_THAT(take(), ElementsAre(2, 3));
  EXPECT_THAT(one.gone, ElementsAre(writer(1)));
  EXPECT_EQ(presenter.octets(), 0u);
  EXPECT_FALSE(presenter.remove_writer(one, writer(1), now));
}

TEST_F(CoherentSets, WhatASetNeeds_IsCountedWithoutEndsOfUnknownInstances) {
  auto sample = change(1, 1, 1, {{1}, {}, {}, {}});
  auto end = change(1, 2, 2, {{1}, {}, {}, {}});
  end.status.unregistered = true;
  presenter.on_change(one, sample, now);
  presenter.on_change(one, end, now);
  put(3, 0, 0);
  EXPECT_EQ(one.instances, 1u);
}

TEST_F(CoherentSets, AWriterThatComesBackBefore_HasNotLeft) {
  one.room = 1;
  put(1, 1, 1), put(2, 2, 1), put(3, 0, 0);
  EXPECT_TRUE(presenter.remove_writer(one, writer(1), now));
  presenter.add_writer(one, writer(1), {}, identity(2));
  put(4, 4, 0);
  one.room = 100;
  presenter.present_ready(now);
  EXPECT_THAT(take(), ElementsAre(1, 2, 4));
  EXPECT_THAT(one.gone, IsEmpty());
  EXPECT_EQ(presenter.octets(), 0u);
}

TEST_F(CoherentSets, WaitingSetOfAWriterThatLeft_GoesWithTheReader) {
  one.room = 1;
  put(1, 1, 1), put(2, 2, 1), put(3, 0, 0);
  EXPECT_TRUE(presenter.remove_writer(one, writer(1), now));
  presenter.remove_reader(one, now);
  EXPECT_EQ(presenter.octets(), 0u);
  one.room = 100;
  presenter.present_ready(now);
  EXPECT_THAT(take(), IsEmpty());
  EXPECT_THAT(one.gone, IsEmpty());
}

TEST_F(CoherentSets, ASetThatWaits_CostsNothingUntilTheReaderHasRoom) {
  one.room = 1;
  put(1, 1, 1), put(2, 2, 1), put(3, 0, 0);
  const auto asked = one.asked;
  for (int number = 4; number < 100; ++number) put(number, 4, number), (void)presenter.next_tick();
  EXPECT_LE(one.asked, asked + 100) << "once for each further set, when it is complete";
  one.room = 100;
  presenter.present_ready(now);
  EXPECT_EQ(take().size(), 2u + 95);
}

TEST_F(CoherentSets, ASetWithAHole_IsNeverSeen) {
  put(2, 2, 1), put(3, 0, 0);  // its first sample is missing
  put(4, 4, 4), put(6, 6, 4), put(7, 0, 0);
  put(8, 8, 8), put(10, 0, 0);  // its last sample is missing
  EXPECT_THAT(take(), IsEmpty());
  EXPECT_EQ(one.lost, 4u);
  put(11, 11, 11), put(12, 0, 0);
  EXPECT_THAT(take(), ElementsAre(11));
}

TEST_F(CoherentSets, WhatDoesNotFit_WaitsAndRefusesMore) {
  one.room = 1;
  put(1, 1, 1), put(2, 2, 1);
  EXPECT_TRUE(put(3, 0, 0));
  EXPECT_THAT(take(), IsEmpty());
  one.room = 2;
  presenter.present_ready(now);
  EXPECT_THAT(take(), ElementsAre(1, 2));
}

TEST_F(CoherentSets, ASetWithoutEnd_IsGivenUp) {
  for (std::size_t i = 1; i <= kMaxSamples; ++i)
    ASSERT_TRUE(put(static_cast<std::int64_t>(i), 1, 1));
  EXPECT_EQ(one.lost, kMaxSamples);
  const auto next = static_cast<std::int64_t>(kMaxSamples) + 1;
  put(next, 0, 0);
  EXPECT_THAT(take(), IsEmpty());
  put(next + 1, 7, 0);
  EXPECT_THAT(take(), ElementsAre(7));
}

// With 64 MiB for each writer, six writers with an open set each took 376 MiB.
TEST_F(CoherentSets, OpenSetsOfAllWriters_HaveOneAccount) {
  constexpr std::uint8_t kWriters = 40;
  const auto payload = Payload::copy_of(Bytes(4 << 20));
  for (std::uint8_t from = 1; from <= kWriters; ++from)
    presenter.add_writer(one, writer(from), {}, identity(from));
  for (std::int64_t number = 1; number <= 4; ++number)
    for (std::uint8_t from = 1; from <= kWriters; ++from) {
      auto next = change(from, number, 1, {{1}, {}, {}, {}});
      next.payload = payload;
      ASSERT_TRUE(presenter.on_change(one, next, now));
    }
  EXPECT_LE(presenter.octets(), Presenter::kMaxOctets);
  EXPECT_GE(one.lost, 4 * kWriters - Presenter::kMaxOctets / payload.size());
}

// One identity has many writers, and each of them has less than the set of another identity. They
// may belong to as many participants: otherwise 40 participants of one certificate displaced all
// sets of an honest writer.
TEST_F(CoherentSets, OpenSetsOfOneIdentity_DoNotDisplaceThoseOfAnother) {
  put(1, 1, 1);
  auto large = change(1, 2, 2, {{1}, {}, {}, {}});
  large.payload = Payload::copy_of(Bytes(1 << 20, 2));
  ASSERT_TRUE(presenter.on_change(one, large, now));
  const auto payload = Payload::copy_of(Bytes(1 << 18));
  for (std::uint32_t i = 0; i < 1000; ++i) {
    auto next = change(static_cast<std::uint8_t>(2 + i % 40), 1, 1, {{1}, {}, {}, {}});
    next.writer.entity =
        EntityId{{static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i), 1, 2}};
    next.payload = payload;
    presenter.add_writer(one, next.writer, {}, identity(2));
    ASSERT_TRUE(presenter.on_change(one, next, now));
  }
  put(3, 0, 0);
  EXPECT_THAT(take(), ElementsAre(1, 2));
}

TEST_F(CoherentSets, ASetThatWasGivenUp_IsNotSeenWithoutItsBeginning) {
  for (std::size_t i = 1; i <= kMaxSamples; ++i) put(static_cast<std::int64_t>(i), 1, 1);
  const auto next = static_cast<std::int64_t>(kMaxSamples) + 1;
  put(next, 1, 1), put(next + 1, 1, 1), put(next + 2, 0, 0);
  EXPECT_THAT(take(), IsEmpty());
  EXPECT_EQ(presenter.octets(), 0u);
}

// Otherwise sets of 1001 samples would wait for ever for a reader of 1000, and would be seen in
// part at the end.
TEST_F(CoherentSets, ASetThatTheReaderCannotHold_IsGivenUpWhole) {
  one.most = 2;
  put(1, 1, 1), put(2, 2, 1), put(3, 3, 1), put(4, 4, 4), put(5, 0, 0);
  EXPECT_EQ(one.lost, 3u);
  EXPECT_THAT(one.limits, ElementsAre(Reader::Limit::samples));
  EXPECT_THAT(take(), ElementsAre(4));
  EXPECT_EQ(presenter.octets(), 0u);
}

TEST_F(CoherentSets, ASetWithoutRoomAtTheEndOfItsWriter_IsSeenWholeLater) {
  one.room = 1;
  put(1, 1, 1), put(2, 2, 1), put(3, 0, 0);
  presenter.remove_writer(one, writer(1), now);
  EXPECT_THAT(take(), IsEmpty());
  one.room = 2;
  presenter.present_ready(now);
  EXPECT_THAT(take(), ElementsAre(1, 2));
  EXPECT_EQ(one.lost, 0u);
  EXPECT_EQ(presenter.octets(), 0u);
}

// Whole sets of one identity wait for the reader. The writers of others go on, and nothing of this
// identity is lost.
TEST_F(CoherentSets, WaitingSetsOfOneIdentity_LeaveRoomForAnother) {
  one.room = 3;
  constexpr std::int64_t kSamples = 8;
  const auto payload = Payload::copy_of(Bytes(1 << 20, 9));
  presenter.add_writer(one, writer(2), {}, identity(2));
  std::int64_t taken = 0;
  for (std::int64_t number = 1; number <= 200; ++number, ++taken) {
    auto next = change(2, number, 9, {{(number - 1) / kSamples * kSamples + 1}, {}, {}, {}});
    next.payload = payload;
    if (!presenter.on_change(one, next, now)) break;
  }
  EXPECT_GE(taken, 60);
  EXPECT_LE(taken, 64);
  put(1, 1, 1), put(2, 2, 1);
  EXPECT_TRUE(put(3, 0, 0));
  EXPECT_THAT(take(), ElementsAre(1, 2));
  EXPECT_EQ(one.lost, 0u);
}

TEST_F(CoherentSets, AWriterThatGoes_TakesItsOpenSetAlong) {
  put(1, 1, 1);
  presenter.remove_writer(one, writer(1), now);
  EXPECT_EQ(one.lost, 1u);
  EXPECT_TRUE(put(2, 2, 0));  // comes too late
  EXPECT_THAT(take(), IsEmpty());
}

struct GroupSets : Presenting {
  Presenter presenter{
      Presenter::PresentedAccess{.is_by_group = true, .is_coherent = true, .is_ordered = true}};
  void SetUp() override {
    presenter.add_writer(one, writer(1), kGroup, identity(1));
    presenter.add_writer(two, writer(2), kGroup, identity(1));
  }
  // `set` is that of the writer, and `group_set` that of the group. The value 0 marks an end.
  void put(std::uint8_t from, std::int64_t number, std::uint8_t value, std::int64_t set,
           std::int64_t group_set, std::int64_t group) {
    auto next = change(from, number, value, {{set}, {group_set}, {group}, {}});
    EXPECT_TRUE(presenter.on_change(from == 1 ? one : two, next, now));
  }
};

TEST_F(GroupSets, ASet_IsSeenWhenAllWritersEndedIt) {
  put(1, 1, 1, 1, 1, 1), put(1, 2, 3, 1, 1, 3);
  put(1, 3, 0, 0, 1, 4);
  EXPECT_THAT(take(), IsEmpty());
  put(2, 1, 2, 1, 1, 2);
  EXPECT_THAT(take(), IsEmpty());
  put(2, 2, 0, 0, 1, 4);
  EXPECT_THAT(take(), ElementsAre(1, 2, 3));
  // In the next set, the second writer has nothing.
  put(1, 4, 5, 4, 5, 5), put(1, 5, 0, 0, 5, 6), put(2, 3, 0, 0, 5, 6);
  EXPECT_THAT(take(), ElementsAre(5));
}

TEST_F(GroupSets, OneHole_SpoilsTheSetForAll) {
  put(1, 1, 1, 1, 1, 1), put(1, 2, 0, 0, 1, 4);
  put(2, 2, 3, 1, 1, 3), put(2, 3, 0, 0, 1, 4);  // its first sample is missing
  EXPECT_THAT(take(), IsEmpty());
  EXPECT_EQ(one.lost + two.lost, 2u);
}

TEST_F(GroupSets, SetsThatNotAllEnd_AreBounded) {
  const auto most = static_cast<std::int64_t>(Presenter::kMaxSets);
  for (std::int64_t n = 1; n <= most; ++n) put(1, n, 1, n, n, n);
  EXPECT_EQ(one.lost, 0u);
  put(1, most + 1, 1, most + 1, most + 1, most + 1);
  EXPECT_EQ(one.lost, 1u);
  put(2, 1, 0, 0, 1, most + 2);  // ends the set that was given up
  EXPECT_THAT(take(), IsEmpty());
}

TEST_F(GroupSets, AWriterThatGoes_IsNotWaitedFor) {
  put(1, 1, 1, 1, 1, 1), put(1, 2, 0, 0, 1, 2);
  presenter.remove_writer(two, writer(2), now);
  EXPECT_THAT(take(), ElementsAre(1));
  presenter.add_writer(two, writer(2), kGroup, identity(1));
  put(2, 1, 3, 1, 3, 3);
  put(1, 3, 0, 0, 3, 5);
  presenter.remove_writer(two, writer(2), now);  // in the middle of the set
  EXPECT_THAT(take(), IsEmpty());
}

TEST_F(GroupSets, WhilePaused_NothingIsSeen) {
  presenter.pause(true, now);
  put(1, 1, 1, 0, 0, 1);
  EXPECT_THAT(take(), IsEmpty());
  EXPECT_EQ(presenter.next_tick(), kNever);
  presenter.pause(false, now);
  EXPECT_THAT(take(), ElementsAre(1));
}

TEST_F(GroupSets, WhatComesTooEarly_WaitsForWhatIsBefore) {
  put(2, 1, 2, 0, 0, 2);
  EXPECT_THAT(take(), IsEmpty());
  put(1, 1, 1, 0, 0, 1);
  EXPECT_THAT(take(), ElementsAre(1, 2));
  // Number 3 was for no reader here, as the heartbeat of the other writer shows.
  put(1, 2, 4, 0, 0, 4);
  EXPECT_THAT(take(), IsEmpty());
  presenter.on_progress(two, writer(2), {4}, now);
  EXPECT_THAT(take(), ElementsAre(4));
}

TEST_F(GroupSets, AHole_IsWaitedForOnlySoLong) {
  put(1, 1, 3, 0, 0, 3);
  EXPECT_EQ(presenter.next_tick(), now + Presenter::kGapTimeout);
  now += Presenter::kGapTimeout;
  presenter.present_ready(now);
  EXPECT_THAT(take(), ElementsAre(3));
}

// A search from number to number would take long if the access is paused.
TEST_F(GroupSets, EqualGroupNumbers_ArePresentedAsTheyCame) {
  presenter.pause(true, now);
  for (std::int64_t number = 1; number <= 50'000; ++number)
    put(1, number, static_cast<std::uint8_t>(1 + number % 2), 0, 0, 1);
  presenter.pause(false, now);
  ASSERT_EQ(seen.size(), 50'000u);
  for (std::size_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen[i], i % 2 == 0 ? 2 : 1);
}

TEST_F(GroupSets, AReaderThatGoes_TakesItsSamplesAlong) {
  put(1, 1, 1, 1, 1, 1), put(2, 1, 2, 1, 1, 2), put(1, 2, 0, 0, 1, 3);
  presenter.remove_reader(one, now);
  put(2, 2, 0, 0, 1, 3);
  EXPECT_THAT(take(), ElementsAre(2));
  EXPECT_EQ(one.lost, 0u);
}

}  // namespace
}  // namespace ddssec::rtps
