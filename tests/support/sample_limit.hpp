// A small limit of samples for a SampleIndex, so that a test reaches it soon.
#pragma once

#include <cstddef>

#include "rtps/durability/sample_index.hpp"

namespace ddssec::rtps {

/// A friend of SampleIndex.
struct SampleLimit {
  /// Sets another limit than SampleIndex::kMaxSamples.
  static void set(SampleIndex& index, std::size_t max_samples) { index.max_samples_ = max_samples; }
};

}  // namespace ddssec::rtps
