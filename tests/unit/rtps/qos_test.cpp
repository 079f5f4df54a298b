#include <functional>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/code_of.hpp"

namespace ddssec::rtps {
namespace {

using test::code_of;

TEST(Qos, Contradictions_AreRefused) {
  const std::pair<std::function<void(Qos&)>, std::string> rows[] = {
      {[](Qos& q) { q.history.depth = 0; }, "HISTORY.depth"},
      {[](Qos& q) { q.durability_service.history.depth = 0; }, "DURABILITY_SERVICE.history_depth"},
      {[](Qos& q) { q.durability_service.limits.max_samples = 0; },
       "DURABILITY_SERVICE.max_samples"},
      {[](Qos& q) { q.history.depth = 5, q.resource_limits.max_samples_per_instance = 4; },
       "HISTORY.depth"},
      {[](Qos& q) { q.resource_limits.max_samples = 0; }, "RESOURCE_LIMITS.max_samples"},
      {[](Qos& q) {
         q.resource_limits = {2, -1, 3};
       },
       "RESOURCE_LIMITS.max_samples_per_instance"},
      {[](Qos& q) {
         q.deadline = {{1, 0}}, q.time_based_filter = {{2, 0}};
       },
       "DEADLINE.period"},
      {[](Qos& q) { q.partition.assign(65, "p"); }, "PARTITION"},
      {[](Qos& q) {
         q.data_tags.assign(kMaxDataTags + 1, {"a", "b"});
       },
       "DATA_TAGS"},
      {[](Qos& q) { q.data_representation.clear(); }, "DATA_REPRESENTATION"},
  };
  EXPECT_TRUE(check_consistency(default_writer_qos()));
  for (const auto& [change, field] : rows) {
    auto qos = default_writer_qos();
    change(qos);
    const auto status = check_consistency(qos);
    ASSERT_EQ(code_of(status), Code::rtps_qos_inconsistent) << field;
    EXPECT_EQ(status.error().details().field, field);
  }
}

}  // namespace
}  // namespace ddssec::rtps
