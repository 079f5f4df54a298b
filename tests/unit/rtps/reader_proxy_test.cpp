#include "rtps/reliability/reader_proxy.hpp"

#include <gtest/gtest.h>

#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

Guid guid(std::uint8_t number) { return {GuidPrefix::from(Bytes(12, number)), testing::kReader}; }

struct Filter final : ChangeFilter {
  std::optional<bool> passes(const Change& change) override { return change.payload.size() > 1; }
};

TEST(ReaderProxy, Changes_AreJudgedByRangeAndFilter) {
  ReaderProxy proxy({.guid = guid(1), .filter = std::make_shared<Filter>()}, {{1}, {4}}, true);
  Change change;
  change.sequence_number = {3};
  change.payload = Payload::copy_of(Bytes(1));
  EXPECT_TRUE(proxy.is_for(change));
  EXPECT_FALSE(proxy.evaluate(change));
  EXPECT_EQ(proxy.rejected_until({3})->value, 4);
  change.sequence_number = {2};
  change.payload = Payload::copy_of(Bytes(2));
  EXPECT_TRUE(proxy.is_evaluated_again(change));
  EXPECT_TRUE(proxy.evaluate(change));
  EXPECT_FALSE(proxy.rejected_until({2}));
  change.payload = Payload::copy_of(Bytes(kMaxEvaluatedOctets + 1));
  EXPECT_FALSE(proxy.is_evaluated_again(change));
  change.payload = {};
  change.status.disposed = true;
  EXPECT_FALSE(proxy.is_evaluated_again(change)) << "filters judge what has data";
  change.sequence_number = {4};
  EXPECT_FALSE(proxy.is_for(change));
  proxy.set_filter(nullptr);
  EXPECT_FALSE(proxy.rejected_until({3}));
}

TEST(ReaderProxy, AnAnswerOnItsWay_IsNotRepeated) {
  ReaderProxy proxy({guid(1), true}, {{1}}, true);
  const auto now = std::chrono::milliseconds(500);
  EXPECT_FALSE(proxy.was_just_answered({3}, now));
  EXPECT_TRUE(proxy.was_just_answered({3}, now + std::chrono::milliseconds(1)));
  EXPECT_FALSE(proxy.was_just_answered({4}, now + std::chrono::milliseconds(1)));
  EXPECT_FALSE(proxy.was_just_answered({4}, now + std::chrono::milliseconds(9)));
}

}  // namespace
}  // namespace ddssec::rtps
