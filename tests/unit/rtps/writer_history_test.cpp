// The changes that a writer still holds when changes in between are dropped.
#include "rtps/reliability/writer_history.hpp"

#include <chrono>
#include <ctime>
#include <map>
#include <set>

#include <gmock/gmock.h>

#include "tests/support/slowdown.hpp"

namespace ddssec::rtps {
namespace {

Change change_of(std::uint8_t instance) {
  Change change;
  change.key_hash = KeyHash{instance};
  change.payload = Payload::copy_of(Bytes{instance});
  return change;
}

Qos keep_last() {
  Qos qos;
  qos.history = {HistoryKind::keep_last, 1};
  return qos;
}

std::vector<std::int64_t> held(const WriterHistory& history) {
  std::vector<std::int64_t> out;
  for (auto number = history.first(); number <= history.last(); number = number.next())
    if (history.find(number) != nullptr) out.push_back(number.value);
  return out;
}

// Otherwise every change after the first one would take a place for ever, with 200 octets each.
TEST(WriterHistory, DroppedAfterOneThatStays_AreForgotten) {
  WriterHistory history(keep_last());
  history.add(change_of(1));
  for (int i = 0; i < 100'000; ++i) {
    history.add(change_of(2));
    history.add(change_of(3));
    ASSERT_LE(history.places(), 2 * history.size() + 65);
  }
  EXPECT_EQ(history.first(), SequenceNumber{1});
  EXPECT_EQ(history.find({1})->payload.view()[0], 1);
  EXPECT_EQ(history.find({2}), nullptr);
  EXPECT_EQ(history.find({200'000})->payload.view()[0], 2);
  EXPECT_EQ(history.find({200'001})->payload.view()[0], 3);
  history.add(change_of(1));
  EXPECT_EQ(history.first(), SequenceNumber{200'000});
  EXPECT_EQ(history.size(), 3u);
}

// The history is compared with a list of what must be held.
TEST(WriterHistory, RandomDrops_LeaveTheLastOfEachInstance) {
  WriterHistory history(keep_last());
  std::map<int, std::int64_t> last;
  std::uint32_t random = 1;
  const auto draw = [&](std::uint32_t most) {
    random = random * 1'664'525 + 1'013'904'223;
    return (random >> 16) % most;
  };
  for (int i = 0; i < 20'000; ++i) {
    const auto instance = static_cast<std::uint8_t>(draw(draw(10) == 0 ? 200 : 5));
    last[instance] = history.add(change_of(instance)).value;
    if (draw(20) == 0) {
      const auto gone = last.begin()->second;
      history.discard({gone});
      last.erase(last.begin());
    }
    if (draw(500) == 0) {
      const auto until = history.last().value - static_cast<std::int64_t>(draw(50));
      history.remove_through({until});
      std::erase_if(last, [&](const auto& entry) { return entry.second <= until; });
    }
    ASSERT_EQ(history.size(), last.size());
    if (i % 97 != 0) continue;
    std::set<std::int64_t> expected;
    for (const auto& [key, number] : last) expected.insert(number);
    ASSERT_THAT(held(history), ::testing::ElementsAreArray(expected));
    for (int n = 0; n < 20; ++n) {
      const SequenceNumber number{1 + draw(static_cast<std::uint32_t>(history.last().value) + 1)};
      const auto from = expected.lower_bound(number.value);
      ASSERT_EQ(history.next_held(number).value,
                from == expected.end() ? history.last().value + 1 : *from);
      ASSERT_EQ(history.previous_held(number).value,
                from == expected.begin() ? 0 : *std::prev(from));
    }
  }
}

// A reader's request, or its match, causes such a search. A request of 40 octets took 13 ms where a
// durability service had removed 500,000 samples in a row.
TEST(WriterHistory, ManyDroppedInARow_CostSearchesNoTime) {
  constexpr std::int64_t kDropped = 200'000;
  Qos qos;
  qos.history.kind = HistoryKind::keep_all;
  qos.resource_limits.max_samples = qos.resource_limits.max_samples_per_instance = 1'000'000;
  WriterHistory history(qos);
  for (std::int64_t i = 0; i < kDropped + 2; ++i) history.add(change_of(1));
  for (std::int64_t i = 0; i < kDropped; ++i) history.discard({i + 2});
  ASSERT_EQ(history.places(), static_cast<std::size_t>(kDropped + 2));
  const auto begin = std::clock();
  for (std::int64_t i = 0; i < 2000; ++i) {
    ASSERT_EQ(history.next_held({2 + i % 100}), SequenceNumber{kDropped + 2});
    ASSERT_EQ(history.previous_held({kDropped + 2 - i % 100}), SequenceNumber{1});
  }
  EXPECT_LT(std::clock() - begin, CLOCKS_PER_SEC * test::kSlowdown / 2);
}

// ---- above the limit of changes

Change end_of(std::uint8_t instance) {
  auto change = change_of(instance);
  change.status = {.disposed = true, .unregistered = true};
  return change;
}

Qos at_most(std::int32_t changes, std::int32_t depth = 1) {
  auto qos = keep_last();
  qos.history.depth = depth;
  qos.resource_limits.max_samples = changes;
  return qos;
}

// Otherwise a late joiner would lack instances that are not written again, after 65,536 changes of
// others.
TEST(WriterHistory, ManyInstancesEnd_LivingOnesAreKept) {
  WriterHistory history(at_most(16));
  const auto config = history.add(change_of(0));
  for (std::uint8_t i = 1; i < 200; ++i) {
    history.add(change_of(i));
    const auto end = history.add(end_of(i));
    ASSERT_NE(history.find(config), nullptr) << int(i);
    ASSERT_NE(history.find(end), nullptr) << "matched readers have not got it yet";
    ASSERT_LE(history.size(), 16U);
  }
}

TEST(WriterHistory, InstanceThatReturned_IsKept) {
  WriterHistory history(at_most(16));
  history.add(change_of(0));
  history.add(end_of(0));
  const auto returned = history.add(change_of(0));
  for (std::uint8_t i = 1; i < 100; ++i) history.add(end_of(i));
  EXPECT_NE(history.find(returned), nullptr);
}

TEST(WriterHistory, DeepHistoriesOfMany_LastSampleOfEachIsKept) {
  WriterHistory history(at_most(16, 8));
  std::vector<SequenceNumber> last;
  for (std::uint8_t i = 0; i < 10; ++i) last.push_back(history.add(change_of(i)));
  for (int i = 0; i < 100; ++i) last[9] = history.add(change_of(9));
  for (const auto number : last) EXPECT_NE(history.find(number), nullptr) << number.value;
  EXPECT_EQ(history.size(), 16U);
}

TEST(WriterHistory, TooManyLivingInstances_OldestGoes) {
  WriterHistory history(at_most(16));
  for (std::uint8_t i = 0; i < 20; ++i) history.add(change_of(i));
  EXPECT_THAT(held(history),
              ::testing::ElementsAre(5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20));
}

// A walk through the history for each change would take milliseconds.
TEST(WriterHistory, ManyMoreLivingInstances_CostNoMoreThanOthers) {
  constexpr std::int32_t kMax = 20'000;
  WriterHistory history(at_most(kMax));
  const auto begin = std::chrono::steady_clock::now();
  for (std::uint32_t i = 0; i < 5 * kMax; ++i) {
    auto change = change_of(1);
    change.key_hash = KeyHash{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8),
                              static_cast<std::uint8_t>(i >> 16)};
    history.add(std::move(change));
  }
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(2) * test::kSlowdown);
  EXPECT_EQ(history.size(), static_cast<std::size_t>(kMax));
}

// A change must not cost a walk through the history to find one that was replaced.
TEST(WriterHistory, DeepHistoriesOfVeryMany_CostNoMoreThanOthers) {
  constexpr std::uint32_t kMax = WriterHistory::kMaxChanges, kMore = 20'000;
  WriterHistory history(at_most(static_cast<std::int32_t>(kMax), 2));
  const auto add = [&](std::uint32_t i) {
    auto change = change_of(1);
    change.key_hash = KeyHash{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8),
                              static_cast<std::uint8_t>(i >> 16)};
    return history.add(std::move(change));
  };
  for (std::uint32_t i = 0; i < kMax; ++i) add(i);
  const auto begin = std::clock();
  std::vector<SequenceNumber> last;
  for (std::uint32_t i = 0; i < kMore; ++i) last.push_back(add(i));
  EXPECT_LT(std::clock() - begin, CLOCKS_PER_SEC * test::kSlowdown);
  EXPECT_EQ(history.size(), kMax);
  for (const auto number : last) ASSERT_NE(history.find(number), nullptr);
  EXPECT_EQ(history.find({1}), nullptr) << "it was replaced";
  EXPECT_NE(history.find({kMore + 1}), nullptr) << "the last of its instance";
}

// The memory for replaced changes does not grow with the number of changes.
TEST(WriterHistory, ADeepHistory_ThatIsReplacedForLong_HoldsItsLatest) {
  WriterHistory history(at_most(1000, 2));
  for (int i = 0; i < 100'000; ++i) history.add(change_of(static_cast<std::uint8_t>(i % 3)));
  EXPECT_EQ(history.size(), 6U);
  EXPECT_THAT(held(history),
              ::testing::ElementsAre(99'995, 99'996, 99'997, 99'998, 99'999, 100'000));
}

}  // namespace
}  // namespace ddssec::rtps
