// A change of an instance, as stored in histories and sent in messages.
#pragma once

#include <cstdint>
#include <optional>

#include "base/ids.hpp"
#include "rtps/reliability/payload.hpp"
#include "wire/inline_qos.hpp"
#include "wire/numbers.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

/// A change of an instance: a sample, or the end of the instance (CacheChange of RTPS 8.2.1.2).
struct Change {
  Guid writer;
  SequenceNumber sequence_number;
  StatusInfo status;  ///< the instance is alive if no flag is set
  std::optional<KeyHash> key_hash;
  std::optional<Time> source_time;
  bool is_key_only = false;  ///< the payload is a serialized key
  Payload payload;           ///< with its encapsulation
  CoherentSetInfo coherence = {};
  OriginalWriterInfo original = {};
  /// Set by a DataReader that has no room for the change. It then knows that `key_hash` names the
  /// instance, and that the change passed the content filter. Another attempt costs the same for
  /// every length of the change.
  bool is_examined = false;
  std::uint32_t key_octets = 0;  ///< length of the key that would be stored, if it is examined

  /// Returns the original writer and its sequence number, even if another writer sent the change.
  OriginalWriterInfo origin() const {
    return original.number.value > 0 ? original : OriginalWriterInfo{writer, sequence_number};
  }

  bool is_alive() const { return status == StatusInfo{}; }
  /// True if the change only marks the end of a coherent set.
  bool is_marker() const { return is_alive() && payload.size() == 0; }
};

}  // namespace ddssec::rtps
