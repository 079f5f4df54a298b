#include "rtps/qos/presets.hpp"

#include <set>

#include <gtest/gtest.h>

#include "rtps/qos/matching.hpp"

namespace ddssec::rtps {
namespace {

TEST(QosPresets, EachPreset_IsThatOfRos2) {
  struct Row {
    const char* name;
    bool reliable;
    DurabilityKind durability;
    std::int32_t depth;
  };
  for (const auto& row : {Row{"sensor_data", false, DurabilityKind::volatile_, 5},
                          Row{"services", true, DurabilityKind::volatile_, 10},
                          Row{"parameters", true, DurabilityKind::volatile_, 1000},
                          Row{"parameter_events", true, DurabilityKind::volatile_, 1000},
                          Row{"default", true, DurabilityKind::volatile_, 10},
                          Row{"latched", true, DurabilityKind::transient_local, 1},
                          Row{"rosout", true, DurabilityKind::transient_local, 1000}}) {
    SCOPED_TRACE(row.name);
    const auto qos = qos_preset(row.name);
    ASSERT_TRUE(qos);
    EXPECT_EQ(qos->is_reliable(), row.reliable);
    EXPECT_EQ(qos->durability, row.durability);
    EXPECT_EQ(qos->history.kind, HistoryKind::keep_last);
    EXPECT_EQ(qos->history.depth, row.depth);
    EXPECT_EQ(qos->lifespan,
              row.name == std::string("rosout") ? (Duration{{10, 0}}) : kDurationInfinite);
    EXPECT_EQ(qos->deadline, kDurationInfinite);
    EXPECT_EQ(qos->liveliness, Liveliness{});
  }
}

TEST(QosPresets, EachPreset_IsConsistentMatchesItselfAndHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (const auto& preset : qos_presets()) {
    const auto qos = qos_preset(preset.name);
    ASSERT_TRUE(qos) << preset.name;
    EXPECT_TRUE(check_consistency(*qos)) << preset.name;
    EXPECT_FALSE(mismatch(*qos, *qos)) << preset.name;
    EXPECT_TRUE(names.insert(preset.name).second) << preset.name;
  }
}

TEST(QosPresets, EachPair_MatchesAsItsPoliciesSay) {
  const auto compatible = [](const char* offered, const char* requested) {
    return !mismatch(*qos_preset(offered), *qos_preset(requested));
  };
  EXPECT_FALSE(compatible("sensor_data", "default"));
  EXPECT_TRUE(compatible("default", "sensor_data"));
  EXPECT_FALSE(compatible("default", "latched"));
  EXPECT_TRUE(compatible("latched", "default"));
}

TEST(QosPresets, AnUnknownName_IsNone) {
  EXPECT_FALSE(qos_preset("sensors"));
  EXPECT_FALSE(qos_preset(""));
}

}  // namespace
}  // namespace ddssec::rtps
