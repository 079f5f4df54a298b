// The ways in which an allow rule is compared with the partitions of an entity.
#pragma once

#include <cstdint>

namespace ddssec::governance {

/// The number of an entity's partitions that an allow rule must list.
enum class PartitionMatch : std::uint8_t {
  all,  ///< every one (DDS-Security 1.2, clause 10.4.1.5.3.4.1.4)
  one,  ///< the "legacy" mode of 1.2: one is enough
};

}  // namespace ddssec::governance
