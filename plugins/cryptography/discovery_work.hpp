// Limits the work that the endpoints of one certificate cause in the host's discovery by coming and
// going. At each match and each end of a reader, Cyclone DDS walks all readers that match the same
// writer: 4,000 readers that ended and came again, beside 1,024 others and 30 writers, kept a
// newcomer out for two minutes.
//
// Each match is charged to the participant and to its certificate. While either is in debt by more
// than it may be, further announcements do not pass. Discovery is reliable: what does not pass is
// sent again, so endpoints are discovered later, and none is refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/work_accounts.hpp"

namespace ddssec::cryptography {

/// The work that one participant causes. Thread-safe.
class DiscoveryWork {
 public:
  /// The time in which a unit is paid off. It is twice that of the certificate's account, so that
  /// one participant leaves half of what the certificate has to others.
  static constexpr MonotonicTime kPrice = 2 * WorkAccount::kPrice;
  /// The price of an attempt to match, in units. It is charged also if the certificate has used up
  /// its matches.
  static constexpr WorkUnits kAttemptUnits = 16;
  /// The least time between two reports of one participant.
  static constexpr MonotonicTime kReportInterval = std::chrono::minutes(1);

  /// The cause of work. What the host does for a local endpoint that its application has just made
  /// is not the peer's work.
  enum class Cause : std::uint8_t { peer, host };

  /// Charges later work also to that account, instead of to the one before.
  void set_account(std::shared_ptr<WorkAccount> account);

  /// Charges an attempt to match one of its endpoints with a local one, to which access control has
  /// agreed. An attempt that access control refuses may come from an announcement that an attacker
  /// forged.
  void note_attempt(Cause cause, MonotonicTime now);
  /// Notes that one of its readers matches a local writer, which matches `standing` others already.
  /// Charges this and, in advance, the end of the match.
  void note_match(std::int64_t local, std::size_t standing, Cause cause, MonotonicTime now);
  /// Notes that the match has ended.
  void note_end_of_match(std::int64_t local, std::size_t standing);
  /// Charges a change of an announced endpoint. If its addresses have changed, the host walks the
  /// readers of all local writers that it matches. Which writers these are is not known here, so
  /// all that any reader of the participant matches count.
  void note_change(MonotonicTime now);

  /// Success if an announcement may pass. Error: announcements_delayed.
  Status check(MonotonicTime now) const;
  /// True if a delay is to be reported now; then the next one is kReportInterval later.
  bool take_report(MonotonicTime now);

 private:
  struct Crowd {
    std::size_t own = 0;       ///< matches of this participant
    std::size_t standing = 0;  ///< readers of the local writer at the last change
  };
  void set_crowd(std::int64_t local, std::size_t own, std::size_t standing);
  void charge(WorkUnits units, MonotonicTime now);

  mutable std::mutex mutex_;
  std::shared_ptr<WorkAccount> account_ = std::make_shared<WorkAccount>();
  WorkDebt debt_{kPrice};
  std::unordered_map<std::int64_t, Crowd> crowds_;  ///< by local writer
  std::size_t crowd_ = 0;                           ///< the sum of all `standing`
  MonotonicTime next_report_ = MonotonicTime::min();
};

}  // namespace ddssec::cryptography
