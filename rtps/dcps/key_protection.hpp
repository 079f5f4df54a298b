// How the protection of an endpoint's payloads affects its keys (DDS-Security 1.2, clause 7.4.4).
#pragma once

#include <atomic>

namespace ddssec::rtps {

/// Both values are set when the endpoint is enabled. Any thread may read them.
struct KeyProtection {
  /// Payloads are encrypted: key hashes must not reveal short keys.
  std::atomic<bool> hidden = false;
  /// Payloads are protected, but the key hash next to them is not.
  std::atomic<bool> proven = false;
};

}  // namespace ddssec::rtps
