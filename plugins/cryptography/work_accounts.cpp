#include "plugins/cryptography/work_accounts.hpp"

namespace ddssec::cryptography {

void WorkAccount::charge(WorkUnits units, MonotonicTime now) {
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

std::shared_ptr<WorkAccount> WorkAccounts::of(SubjectId subject, MonotonicTime now) {
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

}  // namespace ddssec::cryptography
