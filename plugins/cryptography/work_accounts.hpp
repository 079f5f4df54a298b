// The debts of certificates for the work that their participants cause (discovery_work.hpp).
#pragma once

#include <cstddef>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "plugins/cryptography/subject_id.hpp"
#include "plugins/cryptography/work_debt.hpp"

namespace ddssec::cryptography {

/// The debt of the participants of one certificate. Thread-safe.
class WorkAccount {
 public:
  /// The time in which a unit is paid off: 500,000 units in a second, 32 million at once.
  static constexpr MonotonicTime kPrice = std::chrono::microseconds(2);

  /// Adds the cost of work that was done for a participant of the certificate.
  void charge(WorkUnits units, MonotonicTime now);
  /// True if nothing is owed any more.
  bool is_paid(MonotonicTime now) const;
  /// True if so much is owed that no further work is done now (WorkDebt).
  bool is_too_large(MonotonicTime now) const;

 private:
  mutable std::mutex mutex_;
  WorkDebt debt_{kPrice};
};

/// The accounts of all subjects (subject_of in cryptography_state.hpp) that have participants or
/// debts. A participant that leaves takes no debt with it. Thread-safe.
class WorkAccounts {
 public:
  /// Returns the account of the subject, and opens it if there is none. Forgets accounts that are
  /// paid and that no participant holds.
  std::shared_ptr<WorkAccount> of(SubjectId subject, MonotonicTime now);
  /// Returns the number of accounts.
  std::size_t size() const;

 private:
  mutable std::mutex mutex_;
  std::unordered_map<SubjectId, std::shared_ptr<WorkAccount>> accounts_;
};

}  // namespace ddssec::cryptography
