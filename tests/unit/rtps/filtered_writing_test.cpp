// A change that its filter lets through to some readers only.
#include "rtps/reliability/filtered_writing.hpp"

#include <gmock/gmock.h>

#include "rtps/reliability/retransmissions.hpp"
#include "rtps/reliability/stateful_writer.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/rtps/writer_parts.hpp"

namespace ddssec::rtps::writer_parts {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

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
    retransmissions.answer(proxy, readers.one(proxy), missing, now);
    gaps += said().size();
  }
  EXPECT_LE(gaps, 300u);
  EXPECT_EQ(filter->asked, EvaluationAllowance::kMaxOctets);
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
