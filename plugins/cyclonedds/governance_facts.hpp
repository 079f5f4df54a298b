// What our access control shows our authentication of the governance of local participants.
#pragma once

#include <cstdint>
#include <map>
#include <mutex>

#include "plugins/spi/attributes.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// Bits of a mask that crosses from one library to the other (abi.hpp).
enum class GovernanceFact : std::uint32_t {
  allows_unauthenticated = 1,
};
constexpr bool has(std::uint32_t facts, GovernanceFact fact) {
  return (facts & static_cast<std::uint32_t>(fact)) != 0;
}

/// By the permissions of local participants. Thread-safe.
class GovernanceFacts {
 public:
  void note(spi::PermissionsHandle permissions, spi::IdentityHandle local,
            const spi::ParticipantSecurityAttributes& attributes) {
    std::uint32_t facts = 0;
    const auto add = [&](bool holds, GovernanceFact fact) {
      if (holds) facts |= static_cast<std::uint32_t>(fact);
    };
    add(attributes.allow_unauthenticated_participants, GovernanceFact::allows_unauthenticated);
    const std::lock_guard lock(mutex_);
    locals_[permissions] = {local, facts};
  }
  void forget(spi::PermissionsHandle permissions) {
    const std::lock_guard lock(mutex_);
    locals_.erase(permissions);
  }
  /// 0: unknown, or none.
  std::uint32_t of(spi::IdentityHandle local) const {
    const std::lock_guard lock(mutex_);
    for (const auto& [permissions, known] : locals_)
      if (known.local == local) return known.facts;
    return 0;
  }

 private:
  struct Known {
    spi::IdentityHandle local;
    std::uint32_t facts;
  };

  mutable std::mutex mutex_;
  std::map<spi::PermissionsHandle, Known> locals_;
};

}  // namespace ddssec::cyclonedds
