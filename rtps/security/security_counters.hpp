// Counters of a secured participant. They are never reset.
#pragma once

#include <cstdint>

namespace ddssec::rtps {

/// Numbers of messages that were dropped.
struct ProtectionCounters {
  std::uint64_t unprotected = 0;  ///< protection was required but missing
  std::uint64_t undecodable = 0;  ///< protected, but could not be verified
  std::uint64_t unsendable = 0;   ///< could not be protected, and so was not sent
};

/// Numbers of peers.
struct AuthenticationCounters {
  std::uint64_t authenticated = 0;
  std::uint64_t failed = 0;  ///< at least one message or announcement of the peer was refused
};

}  // namespace ddssec::rtps
