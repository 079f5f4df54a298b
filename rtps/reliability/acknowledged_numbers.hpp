// How far the reliable readers of a writer have acknowledged.
#pragma once

#include <optional>
#include <set>

#include "wire/numbers.hpp"

namespace ddssec::rtps {

/// The lowest is known without a search. Nothing is allocated when a reader acknowledges.
class AcknowledgedNumbers {
  using Numbers = std::multiset<SequenceNumber>;

 public:
  /// One reader's place. It is removed before it ends.
  class Place {
    friend class AcknowledgedNumbers;
    std::optional<Numbers::iterator> at_;
  };

  /// The reader has everything up to here.
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
  /// Nothing if there is no reader.
  std::optional<SequenceNumber> lowest() const {
    return numbers_.empty() ? std::nullopt : std::optional(*numbers_.begin());
  }
  /// Every reader has everything up to `last`.
  bool reach(SequenceNumber last) const { return numbers_.empty() || *numbers_.begin() >= last; }

 private:
  Numbers numbers_;
};

}  // namespace ddssec::rtps
