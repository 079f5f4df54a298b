// The debts of certificates for the work that their participants cause (discovery_work.hpp).
#pragma once

#include <cstddef>
#include <cstdint>
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

  void charge(WorkUnits units, MonotonicTime now);
  bool is_paid(MonotonicTime now) const;
  bool is_too_large(MonotonicTime now) const;

 private:
  mutable std::mutex mutex_;
  WorkDebt debt_{kPrice};
};

/// The accounts of all subjects (subject_of in cryptography_state.hpp) that have participants or
/// debts. A participant that leaves takes no debt with it. Thread-safe.
class WorkAccounts {
 public:
  std::shared_ptr<WorkAccount> of(SubjectId subject, MonotonicTime now);
  std::size_t size() const;

 private:
  mutable std::mutex mutex_;
  std::unordered_map<std::uint64_t, std::shared_ptr<WorkAccount>> accounts_;
};

}  // namespace ddssec::cryptography
