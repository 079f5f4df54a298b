// What is known of a peer's governance document.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "plugins/spi/access_control.hpp"
#include "rtps/budget/work_budget.hpp"

namespace ddssec::rtps {

/// The reports of a peer about its governance document; see GovernanceTransition.
struct GovernanceOfPeer {
  enum class State : std::uint8_t {
    changing,  ///< accepts the former protection and that of the document; sends by the former
    changed,   ///< accepts both; sends by that of the document
    in_force,  ///< accepts only that of the document
  };
  struct GovernanceReport {
    spi::AccessControl::GovernanceVersion version;
    State state = State::in_force;
    bool operator==(const GovernanceReport&) const = default;
  };
  std::optional<GovernanceReport> received = {};  ///< the latest
  std::optional<GovernanceReport> sent = {};      ///< the latest that we sent to the peer
  /// True if the peer has accepted the document that is in force here or comes into force. The peer
  /// is then told which protection keys are for, and its endpoints match with either.
  bool takes_part = false;
  /// The protection of messages whose keys were sent to the peer last; see MessageKeys.
  std::uint64_t message_keys = 0;
  /// This participant has keys for the next protection and has not announced it to the peer.
  bool lacks_keys = false;
  /// The peer announced that it lacks keys. Keys are sent again at once for a few such reports, and
  /// for more of them once a second.
  bool wants_keys = false;
  WorkBudget repetitions{3, std::chrono::seconds(5), {}};
  /// It was associated when another governance came into force here, which it did not have.
  bool was_associated_under_former = false;
  WorkBudget answers{3, std::chrono::seconds(5), {}};
};

}  // namespace ddssec::rtps
