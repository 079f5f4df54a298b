#include "plugins/cryptography/discovery_work.hpp"

#include <algorithm>
#include <utility>

namespace ddssec::cryptography {

void WorkDebt::charge(std::size_t units, MonotonicTime now) {
  // More than this in one charge is as good as this, and cannot overflow.
  constexpr std::size_t kMaxUnits = std::size_t{1} << 30;
  until_ = std::max(until_, now) + price_ * static_cast<std::int64_t>(std::min(units, kMaxUnits));
}

void WorkAccount::charge(std::size_t units, MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  debt_.charge(units, now);
}

bool WorkAccount::is_paid(MonotonicTime now) const {
  const std::lock_guard lock(mutex_);
  return debt_.is_paid(now);
}

bool WorkAccount::is_too_large(MonotonicTime now) const {
  const std::lock_guard lock(mutex_);
  return debt_.is_too_large(now);
}

std::shared_ptr<WorkAccount> WorkAccounts::of(std::uint64_t subject, MonotonicTime now) {
  const std::lock_guard lock(mutex_);
  std::erase_if(accounts_, [&](const auto& entry) {
    return entry.second.use_count() == 1 && entry.second->is_paid(now);
  });
  auto& account = accounts_[subject];
  if (!account) account = std::make_shared<WorkAccount>();
  return account;
}

std::size_t WorkAccounts::size() const {
  const std::lock_guard lock(mutex_);
  return accounts_.size();
}

void DiscoveryWork::set_account(std::shared_ptr<WorkAccount> account) {
  const std::lock_guard lock(mutex_);
  account_ = std::move(account);
}

void DiscoveryWork::charge(std::size_t units, MonotonicTime now) {
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
