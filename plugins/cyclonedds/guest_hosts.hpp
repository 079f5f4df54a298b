// Local participants whose governance allows unauthenticated participants.
#pragma once

#include <algorithm>
#include <map>
#include <mutex>

#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// By the permissions that say so. Thread-safe.
class GuestHosts {
 public:
  void note(spi::PermissionsHandle permissions, spi::IdentityHandle local) {
    const std::lock_guard lock(mutex_);
    locals_[permissions] = local;
  }
  void forget(spi::PermissionsHandle permissions) {
    const std::lock_guard lock(mutex_);
    locals_.erase(permissions);
  }
  bool contains(spi::IdentityHandle local) const {
    const std::lock_guard lock(mutex_);
    return std::ranges::any_of(locals_, [&](const auto& entry) { return entry.second == local; });
  }

 private:
  mutable std::mutex mutex_;
  std::map<spi::PermissionsHandle, spi::IdentityHandle> locals_;
};

}  // namespace ddssec::cyclonedds
