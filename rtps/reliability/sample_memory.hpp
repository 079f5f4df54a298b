// The memory into which a writer puts payloads for readers of other processes on this machine: the
// interface to rtps/security.
#pragma once

#include <optional>

#include "base/clock.hpp"
#include "rtps/reliability/change.hpp"

namespace ddssec::rtps {

/// Implemented by the shared memory of one writer.
class SampleMemory {
 public:
  virtual ~SampleMemory() = default;
  /// Puts the payload of a change that was just written into memory. Returns an empty value if it
  /// must be sent in messages. Readers may still request the changes from `needed_from` on.
  /// Allocates nothing once samples of about that size flow.
  virtual std::optional<MemoryReference> store(const Change& change, SequenceNumber needed_from,
                                               MonotonicTime now) = 0;
};

}  // namespace ddssec::rtps
