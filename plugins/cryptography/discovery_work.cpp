#include "plugins/cryptography/discovery_work.hpp"

#include <algorithm>
#include <utility>

namespace ddssec::cryptography {

void DiscoveryWork::set_account(std::shared_ptr<WorkAccount> account) {
  const std::lock_guard lock(mutex_);
  account_ = std::move(account);
}

void DiscoveryWork::charge(WorkUnits units, MonotonicTime now) {
  debt_.charge(units, now);
  account_->charge(units, now);
}

void DiscoveryWork::set_crowd(std::int64_t local, std::size_t own, std::size_t standing) {
  auto& crowd = crowds_[local];
  crowd_ = crowd_ - crowd.standing + standing;
  crowd = {own, standing};
  if (own == 0) crowds_.erase(local);
}

void DiscoveryWork::note_attempt(Cause cause, MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  if (cause == Cause::peer) charge(kAttemptUnits, now);
}

void DiscoveryWork::note_match(std::int64_t local, std::size_t standing, Cause cause,
                               MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  set_crowd(local, crowds_[local].own + 1, standing + 1);
  if (cause == Cause::peer) charge(2 * standing, now);
}

void DiscoveryWork::note_end_of_match(std::int64_t local, std::size_t standing) {
  const std::lock_guard lock(mutex_);
  const auto known = crowds_.find(local);
  if (known == crowds_.end()) return;
  const auto own = known->second.own - 1;
  set_crowd(local, own, own == 0 ? 0 : standing);
}

void DiscoveryWork::note_change(MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  charge(crowd_, now);
}

Status DiscoveryWork::check(MonotonicTime now) const {
  const std::lock_guard lock(mutex_);
  if (!debt_.is_too_large(now) && !account_->is_too_large(now)) return {};
  return fail(Code::announcements_delayed);
}

bool DiscoveryWork::take_report(MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  if (now < next_report_) return false;
  next_report_ = now + kReportInterval;
  return true;
}

}  // namespace ddssec::cryptography
