// How far the change of one participant's governance has come, and what counts besides the
// protection that is in force.
#pragma once

#include <cstdint>
#include <optional>
#include <utility>

#include "plugins/spi/access_control.hpp"

namespace ddssec::rtps {

/// The state of one change of the governance. GovernanceTransition makes the transitions; all other
/// parts of the security only read the state:
///
///   none ---begin---> accepting ---change---> draining ---end---> none
///                     accepting ----------------------------end---> none (the change was dropped)
class GovernanceChangeState {
 public:
  using Version = spi::AccessControl::GovernanceVersion;
  using Attributes = spi::ParticipantSecurityAttributes;

  enum class Phase : std::uint8_t {
    none,
    accepting,  ///< both protections are accepted, the former one is sent
    draining,   ///< both are accepted, the new one is sent
  };

  /// Notes whether a document waits that is to come into force. Not while draining.
  void note_pending(bool is_pending);
  /// Begins the change to the waiting document. `domain` has the participant's attributes under it,
  /// if it protects the whole domain otherwise.
  void begin(const Version& next, std::optional<Attributes> domain);
  /// Notes that the document is in force. `former` is the one before, and `domain` has the
  /// attributes under that, exactly if begin got any.
  void change(const std::optional<Version>& former, std::optional<Attributes> domain);
  /// Ends the change: one protection counts. No document is pending until note_pending says so.
  void end();

  Phase phase() const { return phase_; }
  /// True if endpoints have two protections, or are about to get their second one.
  bool is_under_way() const { return phase_ != Phase::none; }
  /// True if a change is under way, or begins as soon as no keys are being revised.
  bool is_pending() const { return is_pending_; }
  /// True if a governance document has come into force since the participant began.
  bool has_changed() const { return has_changed_; }
  /// Returns the document of the change that is under way.
  const std::optional<Version>& target() const { return target_; }
  /// Returns the document that is not in force: the next one while accepting, the former one while
  /// draining. Empty if no change is under way, or access control has no version of the former one.
  const std::optional<Version>& other_governance() const { return other_governance_; }
  /// Returns the participant's attributes under that document, if the two differ for the domain.
  const std::optional<Attributes>& other_domain() const { return other_domain_; }
  /// Returns the attributes before the last change of the domain, once after it has ended.
  std::optional<Attributes> take_former_domain() {
    return std::exchange(former_domain_, std::nullopt);
  }
  /// True if the participant's own attributes have changed since the last call.
  bool take_changed_domain() { return std::exchange(has_changed_domain_, false); }

 private:
  void assert_invariants() const;

  Phase phase_ = Phase::none;
  bool is_pending_ = false;
  bool has_changed_ = false;
  bool has_changed_domain_ = false;
  std::optional<Version> target_;
  std::optional<Version> other_governance_;
  std::optional<Attributes> other_domain_;
  std::optional<Attributes> former_domain_;
};

}  // namespace ddssec::rtps
