// How the protection of an endpoint's payloads affects its keys (DDS-Security 1.2, clause 7.4.4).
#pragma once

#include <atomic>

namespace ddssec::rtps {

/// Both values are set when the endpoint is enabled. Any thread may read them.
struct KeyProtection {
  /// True if payloads are encrypted: key hashes must not reveal short keys.
  std::atomic<bool> hidden = false;
  /// True if payloads are protected, but the key hash next to them is not.
  std::atomic<bool> proven = false;
};

}  // namespace ddssec::rtps
