// What the protection of an endpoint's payloads means for its keys (DDS-Security 1.2, 7.4.4).
#pragma once

#include <atomic>

namespace ddssec::rtps {

/// Both are decided when the endpoint is enabled. Any thread may read.
struct KeyProtection {
  std::atomic<bool> hidden = false;  ///< payloads are encrypted: hashes must not show short keys
  std::atomic<bool> proven = false;  ///< payloads are protected, and the hash beside them is not
};

}  // namespace ddssec::rtps
