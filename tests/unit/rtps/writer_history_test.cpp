// What a writer still holds, when changes in between are dropped.
#include "rtps/reliability/writer_history.hpp"

#include <map>
#include <set>

#include <gmock/gmock.h>

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

// Before: every change after the first took a place for ever, 200 octets each.
TEST(WriterHistory, ForgetsWhatWasDroppedAfterOneThatStays) {
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

// Against a list of what must be held.
TEST(WriterHistory, HoldsTheLastOfEachInstanceWhateverIsDropped) {
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

}  // namespace
}  // namespace ddssec::rtps
