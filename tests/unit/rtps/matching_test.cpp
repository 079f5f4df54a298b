// Policies that match, and what is reported about those that do not.
#include "rtps/qos/matching.hpp"

#include <ctime>
#include <functional>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

// A policy that is changed on one side, and the report about it: its name and both values.
struct Row {
  std::function<void(Qos& offered, Qos& requested)> change;
  QosPolicyId id;
  std::string policy, offered, requested;
};

TEST(Matching, Durations_AreComparedToTheNanosecond) {
  Qos offered = default_writer_qos(), requested;
  offered.deadline = {{0, 0xb3333334}};    // 700 ms, rounded up
  requested.deadline = {{0, 0xb3333333}};  // rounded down
  EXPECT_EQ(Duration::from(std::chrono::milliseconds(700)), offered.deadline);
  EXPECT_LT(requested.deadline, offered.deadline);
  EXPECT_FALSE(mismatch(offered, requested));
  offered.deadline = Duration::from(std::chrono::nanoseconds(700'000'002));
  EXPECT_TRUE(mismatch(offered, requested));
  offered.deadline = kDurationInfinite;
  EXPECT_TRUE(mismatch(offered, requested));
}

TEST(Matching, EachPolicy_IsNamedWithBothValues) {
  const auto longer = Duration{{2, 0}}, shorter = Duration{{1, 0}};
  const Row rows[] = {
      {[](Qos& o, Qos& r) {
         o.reliability.kind = ReliabilityKind::best_effort;
         r.reliability.kind = ReliabilityKind::reliable;
       },
       QosPolicyId::reliability, "RELIABILITY.kind", "BEST_EFFORT", "RELIABLE"},
      {[](Qos&, Qos& r) { r.durability = DurabilityKind::transient_local; },
       QosPolicyId::durability, "DURABILITY.kind", "VOLATILE", "TRANSIENT_LOCAL"},
      {[](Qos&, Qos& r) { r.presentation.scope = PresentationScope::group; },
       QosPolicyId::presentation, "PRESENTATION.access_scope", "INSTANCE", "GROUP"},
      {[](Qos&, Qos& r) { r.presentation.coherent_access = true; }, QosPolicyId::presentation,
       "PRESENTATION.coherent_access", "false", "true"},
      {[](Qos&, Qos& r) { r.presentation.ordered_access = true; }, QosPolicyId::presentation,
       "PRESENTATION.ordered_access", "false", "true"},
      {[=](Qos& o, Qos& r) { o.deadline = longer, r.deadline = shorter; }, QosPolicyId::deadline,
       "DEADLINE.period", "2.000 s", "1.000 s"},
      {[=](Qos& o, Qos& r) { o.latency_budget = longer, r.latency_budget = shorter; },
       QosPolicyId::latency_budget, "LATENCY_BUDGET.duration", "2.000 s", "1.000 s"},
      {[](Qos& o, Qos&) { o.ownership = OwnershipKind::exclusive; }, QosPolicyId::ownership,
       "OWNERSHIP.kind", "EXCLUSIVE", "SHARED"},
      {[](Qos&, Qos& r) { r.liveliness.kind = LivelinessKind::manual_by_topic; },
       QosPolicyId::liveliness, "LIVELINESS.kind", "AUTOMATIC", "MANUAL_BY_TOPIC"},
      {[=](Qos&, Qos& r) { r.liveliness.lease_duration = shorter; }, QosPolicyId::liveliness,
       "LIVELINESS.lease_duration", "infinite", "1.000 s"},
      {[](Qos&, Qos& r) { r.destination_order = DestinationOrderKind::by_source; },
       QosPolicyId::destination_order, "DESTINATION_ORDER.kind", "BY_RECEPTION_TIMESTAMP",
       "BY_SOURCE_TIMESTAMP"},
      {[](Qos& o, Qos&) { o.data_representation = {DataRepresentation::xcdr2}; },
       QosPolicyId::data_representation, "DATA_REPRESENTATION", "XCDR2", "XCDR1"},
      {[](Qos& o, Qos& r) {
         o.partition = {"a", "b"}, r.partition = {};
       },
       QosPolicyId::partition, "PARTITION", "\"a\", \"b\"", "\"\""},
  };
  for (const auto& row : rows) {
    auto offered = default_writer_qos();
    auto requested = default_reader_qos();
    EXPECT_EQ(mismatch(offered, requested), std::nullopt);
    row.change(offered, requested);
    EXPECT_EQ(mismatch(offered, requested),
              (QosMismatch{row.id, row.policy, row.offered, row.requested}))
        << row.policy;
  }
}

TEST(Matching, TheRemedy_NamesBothSidesAndTheirValues) {
  auto offered = default_writer_qos();
  auto requested = default_reader_qos();
  offered.deadline = Duration::from(std::chrono::milliseconds(500));
  requested.deadline = Duration::from(std::chrono::milliseconds(100));
  const auto late = mismatch(offered, requested);
  ASSERT_TRUE(late);
  EXPECT_EQ(remedy(*late), fmt::format("shorten the writer's DEADLINE.period to {} or lengthen the "
                                       "reader's to {}",
                                       to_string(requested.deadline), to_string(offered.deadline)));
  requested.deadline = offered.deadline;
  requested.partition = {"a"};
  EXPECT_NE(remedy(mismatch(offered, requested).value()).find("partition in common"),
            std::string::npos);
}

TEST(Matching, MoreThanAskedFor_Matches) {
  auto offered = default_writer_qos();
  auto requested = default_reader_qos();
  offered.durability = DurabilityKind::persistent;
  offered.deadline = {{1, 0}}, requested.deadline = {{2, 0}};
  offered.presentation = {PresentationScope::group, true, true};
  offered.destination_order = DestinationOrderKind::by_source;
  requested.data_representation = {DataRepresentation::xcdr2, DataRepresentation::xcdr1};
  EXPECT_EQ(mismatch(offered, requested), std::nullopt);
}

TEST(Matching, Partitions_MatchByExpression) {
  EXPECT_TRUE(partitions_match({}, {""}));
  EXPECT_FALSE(partitions_match({}, {"a"}));
  EXPECT_TRUE(partitions_match({"a*"}, {"x", "abc"}));
  EXPECT_TRUE(partitions_match({"abc"}, {"a?c"}));
  EXPECT_TRUE(partitions_match({"*"}, {}));
  EXPECT_FALSE(partitions_match({"a*"}, {"a*"}));
  EXPECT_FALSE(partitions_match({"A"}, {"a"}));
}

TEST(Matching, Globs_MatchAsFnmatchDoes) {
  EXPECT_TRUE(glob_match("", ""));
  EXPECT_TRUE(glob_match("*", ""));
  EXPECT_FALSE(glob_match("?", ""));
  EXPECT_TRUE(glob_match("a*b*c", "aXbXbYc"));
  EXPECT_FALSE(glob_match("a*b*c", "aXbXbY"));
  EXPECT_TRUE(glob_match("[a-c]x[!0-9]", "bxy"));
  EXPECT_FALSE(glob_match("[a-c]x[!0-9]", "bx5"));
  EXPECT_TRUE(glob_match("[", "["));
  EXPECT_TRUE(glob_match("[]]", "]"));
  EXPECT_TRUE(glob_match("\\*", "*"));
  EXPECT_FALSE(glob_match("\\*", "a"));
  EXPECT_TRUE(glob_match("\\", "\\"));
}

// CVE-2026-22591 was a recursion. Here the worst pattern takes as many steps as the product of the
// lengths of text and pattern.
TEST(Matching, ManyStars_StayCheap) {
  std::string pattern;
  for (int i = 0; i < 128; ++i) pattern += "*a";
  EXPECT_FALSE(glob_match(pattern + "b", std::string(256, 'a')));
}

// A '[' that is never closed is not searched to the end at each character.
TEST(Matching, ManyBrackets_StayCheap) {
  const std::string text(6'000, '[');
  for (const std::string end : {"b", "]b"}) {
    const auto begin = std::clock();
    EXPECT_FALSE(glob_match("*" + std::string(3'000, '[') + end, text)) << end;
    EXPECT_LT(std::clock() - begin, 2 * CLOCKS_PER_SEC) << end;  // processor time
  }
}

}  // namespace
}  // namespace ddssec::rtps
