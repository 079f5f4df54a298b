#include "plugins/access_control/participant.hpp"

#include "governance/live_change.hpp"

namespace ddssec::access_control {
namespace {

bool are_alike(const governance::TopicRule* former, const governance::TopicRule* next) {
  if (former == nullptr || next == nullptr) return former == next;
  return governance::protect_alike(*former, *next);
}

}  // namespace

std::shared_ptr<const Basis> Participant::basis() const {
  const std::lock_guard lock(mutex_);
  return basis_;
}

std::shared_ptr<const Basis> Participant::basis_for(std::string_view topic) const {
  const std::lock_guard lock(mutex_);
  if (topics_in_use_.contains(topic)) return basis_;
  has_more_topics_ = has_more_topics_ || topics_in_use_.size() >= kMostTopicsInUse;
  if (!has_more_topics_) topics_in_use_.emplace(topic);
  return basis_;
}

Status Participant::check_governance(const governance::CompiledGovernance& next) const {
  const std::lock_guard lock(mutex_);
  return check(next);
}

Status Participant::set_basis(Basis basis) {
  auto next = std::make_shared<const Basis>(std::move(basis));
  const std::lock_guard lock(mutex_);
  if (basis_ && next->governance != basis_->governance)
    DDSSEC_RETURN_IF_ERROR(check(*next->governance));
  basis_ = std::move(next);
  return {};
}

/// mutex_ is held.
Status Participant::check(const governance::CompiledGovernance& next) const {
  DDSSEC_ASSIGN_OR_RETURN(
      const auto added,
      governance::added_topic_rules(basis_->governance->domain_rule(), next.domain_rule()));
  for (const auto& topic : topics_in_use_) {
    const auto* const rule = next.topic_rule(topic);
    if (are_alike(basis_->governance->topic_rule(topic), rule)) continue;
    return fail(Code::governance_renewal_refused,
                {.line = rule == nullptr ? 0 : rule->line,
                 .field = "topic_rule",
                 .expected = "the protection that the topic \"" + topic +
                             "\" has: this participant uses it",
                 .found = rule == nullptr ? "no rule" : "a rule with other values"});
  }
  // A topic that had no rule is not in use.
  if (!has_more_topics_ || added.are_last) return {};
  return fail(Code::governance_renewal_refused,
              {.field = "topic_rule",
               .expected = "further rules after the others: this participant uses more than " +
                           std::to_string(kMostTopicsInUse) + " topics",
               .found = "a rule before another one"});
}

}  // namespace ddssec::access_control
