// What a writer knows of a reader's content filter.
#pragma once

#include "rtps/reliability/change.hpp"
#include "wire/content_filter_info.hpp"

namespace ddssec::rtps {

class ChangeFilter {
 public:
  virtual ~ChangeFilter() = default;
  /// Of a change that is alive and carries data. Always the same for the same change. Nothing: the
  /// reader must judge itself, so it gets the change without a result.
  virtual std::optional<bool> passes(const Change& change) = 0;

  FilterSignature signature{};
};

}  // namespace ddssec::rtps
