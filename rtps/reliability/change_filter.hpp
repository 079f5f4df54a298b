// A reader's content filter, as applied by a writer.
#pragma once

#include "rtps/reliability/change.hpp"
#include "wire/content_filter_info.hpp"

namespace ddssec::rtps {

/// Implemented by the content filter of a matched reader.
class ChangeFilter {
 public:
  virtual ~ChangeFilter() = default;
  /// Returns whether a change that is alive and has data passes. The result is always the same for
  /// the same change. If it is empty, the reader must decide, so it gets the change without a
  /// result.
  virtual std::optional<bool> passes(const Change& change) = 0;

  FilterSignature signature{};
};

}  // namespace ddssec::rtps
