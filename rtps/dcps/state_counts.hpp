// Counts the samples of a reader by their three states (DDS 1.4, 2.2.2.5.1).
#pragma once

#include <array>

#include "rtps/dcps/held_instance.hpp"

namespace ddssec::rtps {

/// Says without a search whether any sample has given states.
class StateCounts {
 public:
  /// Adds samples of an instance, or with `sign` -1 subtracts them.
  void add(const HeldInstance& instance, std::size_t unread, std::size_t read, int sign) {
    const auto first = index_of(instance);
    const auto change = [sign](std::size_t& at, std::size_t by) {
      at = sign > 0 ? at + by : at - by;
    };
    change(counts_[first], unread);
    change(counts_[first + 1], read);
  }
  /// True if any sample is in these states.
  bool any(const States& states) const;

 private:
  /// Returns the index of the counter for the instance's unread samples. The counter for its read
  /// samples follows.
  static std::size_t index_of(const HeldInstance& instance) {
    const std::size_t state = instance.state == InstanceState::alive                ? 0
                              : instance.state == InstanceState::not_alive_disposed ? 1
                                                                                    : 2;
    return (state * 2 + (instance.view == ViewState::new_ ? 0 : 1)) * 2;
  }

  std::array<std::size_t, 12> counts_{};
};

inline bool StateCounts::any(const States& states) const {
  constexpr std::array kStates = {InstanceState::alive, InstanceState::not_alive_disposed,
                                  InstanceState::not_alive_no_writers};
  for (std::size_t i = 0; i < counts_.size(); ++i) {
    const bool asked =
        states.sample.contains(i % 2 == 1 ? SampleState::read : SampleState::not_read) &&
        states.view.contains(i / 2 % 2 == 0 ? ViewState::new_ : ViewState::not_new) &&
        states.instance.contains(kStates[i / 4]);
    if (asked && counts_[i] > 0) return true;
  }
  return false;
}

}  // namespace ddssec::rtps
