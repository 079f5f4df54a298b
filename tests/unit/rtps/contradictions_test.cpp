// Messages in one writer's name that cannot all come from it.
#include "rtps/reliability/contradictions.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

const EntityId kWriter{{0, 0, 3, 0xc2}};
const Bytes kOne = {0, 1, 0, 0, 1}, kOther = {0, 1, 0, 0, 2};

Data data(std::int64_t number, BytesView payload = kOne) {
  return {{}, kWriter, {number}, {}, PayloadKind::data, payload};
}
Heartbeat heartbeat(std::int64_t first, std::int64_t last) {
  return {.reader = {}, .writer = kWriter, .first = {first}, .last = {last}, .count = 1};
}
Gap gap(std::int64_t start, std::int64_t end, std::int64_t more = 0) {
  SequenceNumberSet list(SequenceNumber{end});
  if (more > 0) list.insert({more});
  return {{}, kWriter, {start}, list};
}

TEST(ContradictionsTest, HonestMessages_HaveNone) {
  Contradictions messages;
  EXPECT_FALSE(messages.note(heartbeat(1, 0)));
  for (std::int64_t number = 1; number <= 1000; ++number) {
    EXPECT_FALSE(messages.note(data(number), {number}));
    EXPECT_FALSE(messages.note(heartbeat(1, number)));
    EXPECT_FALSE(messages.note(data(number), {number + 1})) << "it is sent again";
  }
  messages.note(gap(5, 10, 12));
  EXPECT_FALSE(messages.note(heartbeat(900, 1000)));
  EXPECT_FALSE(messages.note(data(1001), {1001}));
}

TEST(ContradictionsTest, LateChange_IsNone) {
  Contradictions messages;
  EXPECT_FALSE(messages.note(data(3), {1}));
  EXPECT_FALSE(messages.note(data(2), {1}));
  EXPECT_FALSE(messages.note(heartbeat(1, 3)));
  EXPECT_FALSE(messages.note(data(1), {1}));
}

TEST(ContradictionsTest, OtherContent_IsOne) {
  Contradictions messages;
  EXPECT_FALSE(messages.note(data(1, kOne), {1}));
  EXPECT_TRUE(messages.note(data(1, kOther), {2}));
  auto end = data(1, kOne);
  end.inline_qos.status.disposed = true;
  EXPECT_TRUE(messages.note(end, {2}));
  auto of_another = data(1, kOne);
  of_another.inline_qos.key_hash.emplace().fill(7);
  EXPECT_TRUE(messages.note(of_another, {2}));
  EXPECT_FALSE(messages.note(data(1, kOne), {2}));
}

TEST(ContradictionsTest, ChangeThatWasSkipped_IsOne) {
  Contradictions messages;
  EXPECT_TRUE(messages.note(data(1), {2}));
}

TEST(ContradictionsTest, HeartbeatBelowWhatWasNamed_IsOne) {
  const auto after = [](const auto& message, auto... next) {
    Contradictions messages;
    messages.note(message, next...);
    EXPECT_FALSE(messages.note(heartbeat(1, 20)));
    return messages.note(heartbeat(1, 19)) && !Contradictions().note(heartbeat(1, 19));
  };
  EXPECT_TRUE(after(heartbeat(1, 20)));
  EXPECT_TRUE(after(heartbeat(21, 20)));
  EXPECT_TRUE(after(data(20), SequenceNumber{1}));
  EXPECT_TRUE(after(gap(1, 21)));
  EXPECT_TRUE(after(gap(1, 2, 20)));
}

TEST(ContradictionsTest, Fragments_AreOneWhereThereWereNone) {
  DataFrag frag;
  frag.sequence_number = {1};
  Contradictions messages;
  EXPECT_FALSE(messages.note(frag, {1}));
  EXPECT_FALSE(messages.note(frag, {2}));
  EXPECT_TRUE(messages.note(data(1), {2}));
  EXPECT_FALSE(messages.note(data(2), {2}));
  frag.sequence_number = {2};
  EXPECT_TRUE(messages.note(frag, {3}));
}

// If a forgotten message is repeated, this leads to one reading at worst.
TEST(ContradictionsTest, BeyondTheLimit_TheEarliestAreForgotten) {
  Contradictions messages;
  constexpr auto kMax = static_cast<std::int64_t>(Contradictions::kMaxRemembered);
  for (std::int64_t number = 1; number <= kMax + 1; ++number)
    EXPECT_FALSE(messages.note(data(number), {number}));
  EXPECT_TRUE(messages.note(data(1), {kMax + 2}));
  EXPECT_FALSE(messages.note(data(2), {kMax + 2}));
}

}  // namespace
}  // namespace ddssec::rtps
