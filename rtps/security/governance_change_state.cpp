#include "rtps/security/governance_change_state.hpp"

#include <cassert>

namespace ddssec::rtps {

void GovernanceChangeState::note_pending(bool is_pending) {
  assert(phase_ != Phase::draining);
  is_pending_ = is_pending;
  assert_invariants();
}

void GovernanceChangeState::begin(const Version& next, std::optional<Attributes> domain) {
  assert(phase_ == Phase::none && is_pending_);
  phase_ = Phase::accepting;
  target_ = other_governance_ = next;
  other_domain_ = std::move(domain);
  assert_invariants();
}

void GovernanceChangeState::change(const std::optional<Version>& former,
                                   std::optional<Attributes> domain) {
  assert(phase_ == Phase::accepting);
  assert(domain.has_value() == other_domain_.has_value());
  phase_ = Phase::draining;
  other_governance_ = former;
  other_domain_ = std::move(domain);
  has_changed_ = true;
  has_changed_domain_ = has_changed_domain_ || other_domain_.has_value();
  assert_invariants();
}

void GovernanceChangeState::end() {
  assert(phase_ != Phase::none);
  if (phase_ == Phase::draining) former_domain_ = other_domain_;
  phase_ = Phase::none;
  is_pending_ = false;
  target_.reset();
  other_governance_.reset();
  other_domain_.reset();
  assert_invariants();
}

void GovernanceChangeState::assert_invariants() const {
  assert(target_.has_value() == is_under_way());
  assert(is_under_way() || (!other_governance_ && !other_domain_));
  assert(phase_ != Phase::accepting || other_governance_ == target_);
  assert(phase_ != Phase::draining || has_changed_);
  assert(!is_under_way() || is_pending_);
}

}  // namespace ddssec::rtps
