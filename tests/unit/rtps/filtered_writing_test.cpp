// A change that its filter lets through to some readers only.
#include "rtps/reliability/filtered_writing.hpp"

#include <gmock/gmock.h>

#include "rtps/reliability/retransmissions.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/rtps/writer_parts.hpp"

namespace ddssec::rtps::writer_parts {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::EndsWith;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::StartsWith;

const Locator kHere = *Locator::parse("127.0.0.1", 1);
const Locator kThere = *Locator::parse("127.0.0.2", 1);

Guid guid(std::uint8_t number) { return {GuidPrefix::from(Bytes(12, number)), testing::kReader}; }

// A filter that passes nothing, and counts how often it is asked.
struct CountingFilter final : ChangeFilter {
  std::optional<bool> passes(const Change&) override {
    ++asked;
    return false;
  }
  std::size_t asked = 0;
};

Change sample_of(std::size_t octets) {
  Change change;
  change.payload = Payload::copy_of(Bytes(octets));
  return change;
}

TEST_F(WriterParts, RequestsOfAFilteredReader_CostFewGapsAndEvaluations) {
  constexpr std::int64_t kHeld = 600;
  for (std::int64_t i = 0; i < kHeld; ++i) add();
  const auto filter = std::make_shared<CountingFilter>();
  auto& proxy = readers.add({guid(1), true, true, {kHere}}, {{1}});
  readers.set_filter(proxy, filter);
  std::size_t gaps = 0;
  for (std::int64_t base = 1; base <= 300; ++base) {
    SequenceNumberSet missing({base});
    for (std::int64_t number = base; number < base + 256; ++number) missing.insert({number});
    readers.set_filter(proxy, filter);  // so that it is evaluated again
    retransmissions.answer(proxy, readers.one(proxy), missing, now);
    gaps += said().size();
  }
  EXPECT_LE(gaps, 300u);
  EXPECT_EQ(filter->asked, EvaluationAllowance::kMaxOctets);
}

TEST_F(WriterParts, WhatAFilterRejected_IsNotEvaluatedAgain) {
  for (int i = 0; i < 3; ++i) add();
  const auto filter = std::make_shared<CountingFilter>();
  auto& proxy = readers.add({guid(1), true, true, {kHere}, false, filter}, {{1}});
  for (int i = 0; i < 5; ++i, now += milliseconds(100)) {
    EXPECT_TRUE(request(proxy, {1, 2, 3}));
    EXPECT_THAT(said(), ElementsAre("gap 1-4"));
  }
  EXPECT_EQ(filter->asked, 3u);
  readers.set_filter(proxy, nullptr);
  EXPECT_TRUE(request(proxy, {1, 2, 3}));
  EXPECT_THAT(said(), ElementsAre("data 1", "data 2", "data 3"));
}

// Otherwise an attacker that drops one datagram would make the writer send all of them.
TEST_F(WriterParts, OneLostGap_MakesNoRejectedSampleLeave) {
  const auto filter = std::make_shared<CountingFilter>();
  auto& proxy = readers.add({guid(1), true, true, {kHere}, false, filter}, {{1}});
  for (int i = 0; i < 5; ++i) filtered.send(add(kMaxEvaluatedOctets + 1));
  filtered.send_gaps({6});
  EXPECT_THAT(said(), ElementsAre("gap 1-6"));
  EXPECT_TRUE(request(proxy, {1, 2, 3, 4, 5}));
  EXPECT_THAT(said(), ElementsAre("gap 1-6"));
  EXPECT_TRUE(retransmissions.begin(proxy, nack(3, 2), now));
  EXPECT_FALSE(retransmissions.send_portion(proxy, readers.one(proxy), now));
  EXPECT_THAT(said(), ElementsAre("gap 3-4"));
  EXPECT_EQ(filter->asked, 5u);
}

TEST_F(WriterParts, LargeSamplesThatAFilteredReaderRequests_AreNotDecoded) {
  add(kMaxEvaluatedOctets);
  add(kMaxEvaluatedOctets + 1);
  sender.fragment_at(10'000);
  const auto filter = std::make_shared<CountingFilter>();
  auto& proxy = readers.add({guid(1), true, true, {kHere}, false, filter}, {{1}});
  EXPECT_TRUE(request(proxy, {1, 2}));
  EXPECT_EQ(filter->asked, 1u);
  const auto answer = said();
  EXPECT_EQ(answer.front(), "gap 1-2");
  EXPECT_THAT(answer, Contains("fragment 1"));
  for (int i = 0; i < 100; ++i) {
    now += milliseconds(10);
    EXPECT_TRUE(retransmissions.begin(proxy, nack(2, 2), now));
    EXPECT_TRUE(retransmissions.send_portion(proxy, readers.one(proxy), now));
  }
  EXPECT_EQ(filter->asked, 1u);
}

// It gets what its filter lets through, as fast as samples may be decoded.
TEST_F(WriterParts, LargeHistoryThatAFilteredReaderRequests_IsDecodedInTurns) {
  for (int i = 0; i < 10; ++i) add(kMaxEvaluatedOctets);
  const auto filter = std::make_shared<CountingFilter>();
  auto& proxy = readers.add({guid(1), true, true, {kHere}, false, filter}, {{1}});
  EXPECT_TRUE(request(proxy, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
  EXPECT_THAT(said(), ElementsAre("gap 1-4"));
  EXPECT_EQ(filter->asked, 3u);
  for (std::int64_t next = 4; next <= 10; ++next) {
    now += milliseconds(70);
    EXPECT_TRUE(request(proxy, {next, 10}));
    for (const auto& words : said()) EXPECT_THAT(words, StartsWith("gap"));
  }
  EXPECT_EQ(filter->asked, 10u);
}

TEST_F(WriterParts, AReaderThatOthersKeepFromEvaluations_DecidesItself) {
  add(2000);
  add(2000);
  const auto filter = std::make_shared<CountingFilter>();
  auto& proxy = readers.add({guid(1), true, true, {kHere}, false, filter}, {{1}});
  const auto ask = [&] {
    evaluations.renewed(now);
    evaluations.spend(EvaluationAllowance::kMaxOctets);
    EXPECT_TRUE(request(proxy, {1, 2}));
    return said();
  };
  EXPECT_THAT(ask(), IsEmpty());
  now += ReaderProxy::kMaxEvaluationWait;
  EXPECT_THAT(ask(), ElementsAre("data 1"));
  EXPECT_EQ(filter->asked, 0u);
  now += milliseconds(10);
  EXPECT_TRUE(request(proxy, {2}));
  EXPECT_THAT(said(), ElementsAre("gap 2-3"));
}

TEST_F(WriterParts, LargeHistoryForAFilteredReader_IsNotDecoded) {
  auto qos = keep_all();
  qos.durability = DurabilityKind::transient_local;
  StatefulWriter writer({kA, testing::kWriter}, qos, sender);
  for (const auto octets : {kMaxEvaluatedOctets, kMaxEvaluatedOctets + 1})
    writer.write(sample_of(octets), now);
  const auto filter = std::make_shared<CountingFilter>();
  writer.match({guid(1), false, true, {kHere}, false, filter}, now);
  EXPECT_EQ(filter->asked, 1u);
  EXPECT_FALSE(said().empty());
}

TEST_F(WriterParts, ALateJoinerWithAFilter_GetsNoHistoryBeyondTheAllowance) {
  auto qos = keep_all();
  qos.durability = DurabilityKind::transient_local;
  StatefulWriter writer({kA, testing::kWriter}, qos, sender);
  constexpr std::size_t kOctets = 300 << 10;
  for (int i = 0; i < 20; ++i) writer.write(sample_of(kOctets), now);
  const auto filter = std::make_shared<CountingFilter>();
  writer.match({guid(1), false, true, {kHere}, false, filter}, now);
  EXPECT_THAT(said(), IsEmpty());
  EXPECT_EQ(filter->asked, EvaluationAllowance::kMaxOctets / evaluation_price(kOctets));
}

TEST_F(WriterParts, ALargeSample_IsDecodedForFewFilters) {
  const auto filter = std::make_shared<CountingFilter>();
  for (std::uint8_t n = 1; n <= StatefulWriter::kMaxFilters; ++n)
    readers.add({guid(n), true, false, {kHere}, false, filter}, {{1}});
  filtered.send(add(1000));
  EXPECT_EQ(std::exchange(filter->asked, 0), StatefulWriter::kMaxFilters);
  filtered.send(add(FilteredWriting::kMaxDecoded / 4));
  EXPECT_EQ(std::exchange(filter->asked, 0), 4u);
  filtered.send(add(2 * FilteredWriting::kMaxDecoded));
  EXPECT_EQ(filter->asked, 1u);
}

// The GAP for what was rejected before must not name what is written meanwhile.
TEST_F(WriterParts, WhatIsWrittenWhileSuspended_IsInNoGap) {
  StatefulWriter writer({kA, testing::kWriter}, keep_all(), sender);
  writer.match({guid(1), true, false, {kHere}, false, std::make_shared<Filter>()}, now);
  said();
  for (int i = 0; i < 3; ++i) writer.write(sample_of(1), now);
  writer.suspend();
  writer.write(sample_of(2), now);
  writer.tick(now += std::chrono::seconds(1));
  writer.resume(now);
  writer.write(sample_of(2), now);
  const auto all = said();
  EXPECT_THAT(all, Contains(AllOf(StartsWith("gap"), EndsWith("-4"))));
  EXPECT_THAT(all, Contains("data 4"));
  EXPECT_THAT(all, Not(Contains(AllOf(StartsWith("gap"), EndsWith("-5")))));
}

TEST_F(WriterParts, AFilteredChange_GoesToThoseThatWantIt) {
  readers.add({guid(1), true, false, {kHere}, false, std::make_shared<Filter>()}, {{1}});
  filtered.send(add(1));
  EXPECT_THAT(said(), IsEmpty());
  filtered.send(add(2));
  EXPECT_THAT(said(), ElementsAre("gap 1-2", "data 2"));
  readers.add({guid(2), true, false, {kThere}}, {{3}});
  filtered.send(add(2));
  EXPECT_THAT(said(), ElementsAre("data 3 to all"));
  filtered.send(add(1));
  EXPECT_THAT(said(), ElementsAre("data 4"));
}

}  // namespace
}  // namespace ddssec::rtps::writer_parts
