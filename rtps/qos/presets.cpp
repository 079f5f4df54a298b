#include "rtps/qos/presets.hpp"

#include <algorithm>
#include <array>

namespace ddssec::rtps {
namespace {

constexpr auto kReliable = ReliabilityKind::reliable;
constexpr auto kVolatile = DurabilityKind::volatile_;
constexpr auto kTransientLocal = DurabilityKind::transient_local;

// The values are from ROS 2, rmw/qos_profiles.h. "latched" is the ROS 2 equivalent of ROS 1's
// latched topics.
constexpr std::array kPresets = {
    QosPreset{"default", kReliable, kVolatile, 10},
    QosPreset{"sensor_data", ReliabilityKind::best_effort, kVolatile, 5},
    QosPreset{"services", kReliable, kVolatile, 10},
    QosPreset{"parameters", kReliable, kVolatile, 1000},
    QosPreset{"parameter_events", kReliable, kVolatile, 1000},
    QosPreset{"rosout", kReliable, kTransientLocal, 1000, 10},
    QosPreset{"latched", kReliable, kTransientLocal, 1},
};

}  // namespace

std::span<const QosPreset> qos_presets() { return kPresets; }

std::optional<Qos> qos_preset(std::string_view name) {
  const auto found = std::ranges::find(kPresets, name, &QosPreset::name);
  if (found == kPresets.end()) return std::nullopt;
  Qos qos;
  qos.reliability.kind = found->reliability;
  qos.durability = found->durability;
  qos.history.depth = found->depth;
  // A late joiner gets as many samples as the writer keeps.
  if (found->durability != kVolatile) qos.durability_service.history = qos.history;
  if (found->lifespan > 0) qos.lifespan = Duration{{found->lifespan, 0}};
  return qos;
}

}  // namespace ddssec::rtps
