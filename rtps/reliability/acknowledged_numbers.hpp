// The sequence numbers that the reliable readers of a writer have acknowledged.
#pragma once

#include <optional>
#include <set>

#include "wire/numbers.hpp"

namespace ddssec::rtps {

/// The lowest number is known without a search, and acknowledging allocates nothing.
class AcknowledgedNumbers {
  using Numbers = std::multiset<SequenceNumber>;

 public:
  /// The entry of one reader. It must be removed before it is destroyed.
  class Place {
    friend class AcknowledgedNumbers;
    std::optional<Numbers::iterator> at_;
  };

  /// Notes that the reader has received everything up to `through`.
  void set(Place& place, SequenceNumber through) {
    if (!place.at_) {
      place.at_ = numbers_.insert(through);
      return;
    }
    auto node = numbers_.extract(*place.at_);
    node.value() = through;
    place.at_ = numbers_.insert(std::move(node));
  }
  void remove(Place& place) {
    if (place.at_) numbers_.erase(*place.at_);
    place.at_.reset();
  }
  /// Returns the lowest number that a reader has acknowledged; empty if there is no reader.
  std::optional<SequenceNumber> lowest() const {
    return numbers_.empty() ? std::nullopt : std::optional(*numbers_.begin());
  }
  /// True if every reader has received everything up to `last`.
  bool reach(SequenceNumber last) const { return numbers_.empty() || *numbers_.begin() >= last; }

 private:
  Numbers numbers_;
};

}  // namespace ddssec::rtps
