// Named sets of policies: those of ROS 2 (rmw). They let an application join a topic of a ROS 2
// system without setting each policy.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

/// A named set of policies. HISTORY is KEEP_LAST.
struct QosPreset {
  std::string_view name;
  ReliabilityKind reliability;
  DurabilityKind durability;
  std::int32_t depth;         ///< the depth of HISTORY
  std::int32_t lifespan = 0;  ///< seconds; 0 means infinite
};

/// The table of presets; valid as long as the program.
std::span<const QosPreset> qos_presets();

/// Returns the policies for writers and readers; all other policies have the defaults of DDS. Empty
/// if the name is not in the table.
std::optional<Qos> qos_preset(std::string_view name);

}  // namespace ddssec::rtps
