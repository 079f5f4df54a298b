#include "plugins/access_control/permissions_holder.hpp"

#include <algorithm>

namespace ddssec::access_control {

Result<Grant> PermissionsHolder::grant(WallTime now) {
  if (!document_) return fail(Code::peer_has_no_permissions);
  const std::lock_guard lock(mutex_);
  if (grant_ && grant_->grant().validity.contains(now) && document_->check_signer(now)) {
    return grant_;
  }
  auto found = document_->grant_for(subject_.name, subject_.shown, participant_->domain, now);
  if (!found) return std::unexpected(found.error().in(document_name_));
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

void PermissionsHolder::mark_reported() {
  const std::lock_guard lock(mutex_);
  reported_ = true;
}

}  // namespace ddssec::access_control
