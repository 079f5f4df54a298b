// A change of an instance: what histories hold and messages carry.
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "rtps/reliability/payload.hpp"
#include "wire/inline_qos.hpp"
#include "wire/numbers.hpp"
#include "wire/time.hpp"

namespace ddssec::rtps {

struct Change {
  Guid writer;
  SequenceNumber sequence_number;
  StatusInfo status;  ///< neither: alive
  std::optional<KeyHash> key_hash;
  std::optional<Time> source_time;
  bool key_only = false;  ///< the payload is a serialized key
  Payload payload;        ///< with its encapsulation
  Coherence coherence = {};
  Original original = {};

  /// The original writer and its number, whichever writer sent it.
  Original origin() const {
    return original.number.value > 0 ? original : Original{writer, sequence_number};
  }

  bool is_alive() const { return status == StatusInfo{}; }
  /// Ends a coherent set, and is nothing else.
  bool is_marker() const { return is_alive() && payload.size() == 0; }
};

}  // namespace ddssec::rtps
