// The properties that decide whether samples may go through shared memory.
#pragma once

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// How a participant may pass payloads in shared memory. Off by default, because the kernel then
/// sees them.
struct SharedMemory {
  bool is_on = false;
  /// True if the kernel of this machine may see payloads of which only messages or submessages are
  /// encrypted.
  bool trusts_kernel = false;
  /// The limit for the memory that a participant creates.
  std::size_t max_octets = std::size_t{256} << 20;
  /// True if processes of other users take part.
  bool with_other_users = false;
  bool operator==(const SharedMemory&) const = default;
};

/// Returns the values of `org.ddssec.shm` ("on" or "off"), `org.ddssec.shm.trust_kernel` and
/// `org.ddssec.shm.other_users` ("true" or "false"), and `org.ddssec.shm.max_octets` (at most 1
/// TiB); off, false and 256 MiB if they are missing. Error: invalid_property.
Result<SharedMemory> shared_memory(const PropertyList& properties);

}  // namespace ddssec::spi
