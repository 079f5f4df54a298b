// The state that the writers of one publisher with GROUP access have in common (RTPS 8.7.6).
#pragma once

#include "wire/inline_qos.hpp"

namespace ddssec::rtps {

/// The position of a publisher with GROUP access scope, shared by its writers.
struct WriterGroup {
  SequenceNumber current;  ///< the last group sequence number that was assigned; 0 if none was
  GroupDigest writers = {};
};

}  // namespace ddssec::rtps
