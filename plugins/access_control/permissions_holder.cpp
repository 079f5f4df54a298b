#include "plugins/access_control/permissions_holder.hpp"

#include <algorithm>

#include "governance/grant.hpp"

namespace ddssec::access_control {
namespace {

bool say_the_same(const governance::Criteria& a, const governance::Criteria& b) {
  return a.topics == b.topics && a.partitions == b.partitions && a.data_tags == b.data_tags;
}

bool say_the_same(const governance::Rule& a, const governance::Rule& b) {
  const auto equal = [](const auto& of_a, const auto& of_b) {
    return std::ranges::equal(of_a, of_b,
                              [](const auto& x, const auto& y) { return say_the_same(x, y); });
  };
  return a.allow == b.allow && a.domains == b.domains && equal(a.publish, b.publish) &&
         equal(a.subscribe, b.subscribe) && equal(a.relay, b.relay);
}

bool give_the_same(const governance::Grant& a, const governance::Grant& b) {
  return a.default_allow == b.default_allow &&
         std::ranges::equal(a.rules, b.rules,
                            [](const auto& x, const auto& y) { return say_the_same(x, y); });
}

}  // namespace

bool PermissionsHolder::is_over(WallTime now) const {
  return now >= grant_->grant().validity.not_after || now > document_->signer_not_after();
}

Result<Grant> PermissionsHolder::grant(WallTime now) {
  if (!document_) return fail(Code::peer_has_no_permissions);
  const std::lock_guard lock(mutex_);
  if (grant_ && !is_over(now)) return grant_;
  auto found = document_->grant_for(subject_.name, subject_.shown, participant_->domain,
                                    participant_->domain_tag, now);
  if (!found) return std::unexpected(found.error().in(document_name_));
  // Hosts do not judge again what they have matched.
  if (remote_ && grant_ && !give_the_same(grant_->grant(), (*found)->grant()))
    if (auto ended = governance::check_validity(grant_->grant(), now); !ended)
      return std::unexpected(ended.error().in(document_name_));
  grant_ = *found;
  return grant_;
}

std::optional<WallTime> PermissionsHolder::ends() const {
  const std::lock_guard lock(mutex_);
  if (!grant_ || reported_) return std::nullopt;
  // A certificate is valid up to and including its last second.
  return std::min(grant_->grant().validity.not_after,
                  document_->signer_not_after() + std::chrono::seconds(1));
}

std::optional<Error> PermissionsHolder::newly_ended(WallTime now) {
  if (!document_) return std::nullopt;
  auto valid = grant(now);
  const std::lock_guard lock(mutex_);
  if (valid || reported_) return std::nullopt;
  return std::move(valid).error();
}

std::optional<Error> PermissionsHolder::ends_soon(WallTime now) {
  const auto end = ends();
  if (!end) return std::nullopt;
  const std::lock_guard lock(mutex_);
  if (!warning_.is_due(grant_->grant().validity.not_before, *end, now)) return std::nullopt;
  if (document_->grant_for(subject_.name, subject_.shown, participant_->domain,
                           participant_->domain_tag, *end))
    return std::nullopt;
  return Error(
      Code::permissions_end_soon,
      {.document = document_name_, .field = "not_after", .found = spi::in_time(*end, now)});
}

void PermissionsHolder::mark_reported() {
  const std::lock_guard lock(mutex_);
  reported_ = true;
}

}  // namespace ddssec::access_control
