// Sets of policies with a name: those of ROS 2 (rmw), so that a topic of a ROS 2 system is joined
// without writing each policy out.
#pragma once

#include <optional>
#include <span>

#include "rtps/qos/qos.hpp"

namespace ddssec::rtps {

struct QosPreset {
  std::string_view name;
  ReliabilityKind reliability;
  DurabilityKind durability;
  std::int32_t depth;         ///< of HISTORY KEEP_LAST
  std::int32_t lifespan = 0;  ///< seconds; 0: infinite
};

/// All there are.
std::span<const QosPreset> qos_presets();

/// For writers and readers alike: everything else is as DDS has it by default. Nothing for a name
/// that is not in the table.
std::optional<Qos> qos_preset(std::string_view name);

}  // namespace ddssec::rtps
