// Remembers whose folders made the agent wait.
#pragma once

#include <chrono>
#include <map>
#include <sys/types.h>

namespace ddssec::cli {

/// The users whose workers did not answer in time. The agent looks after one folder at a time, and
/// an owner can stop the worker of a folder. So the agent waits less for the workers of such an
/// owner for a while. After that the owner has the full time again: a token or a name server may
/// have been slow.
class SlowOwners {
 public:
  using Moment = std::chrono::nanoseconds;  ///< of Clock::since_boot
  /// The time to answer. A worker may have to wait for a token, or for another command that has
  /// locked the folder.
  static constexpr std::chrono::seconds kTime{60};
  static constexpr std::chrono::seconds kTimeIfSlow{3};
  static constexpr std::chrono::hours kSlowFor{1};

  /// `own` is the agent's user. That user never counts as slow, because it can stop the agent
  /// itself.
  explicit SlowOwners(uid_t own) : own_(own) {}

  /// Returns how long a worker of this owner may take to answer.
  std::chrono::seconds time_for(uid_t owner, Moment now) const;
  /// Notes that a worker of this owner took too long. If the owner is slow already, this does not
  /// last longer because of that, since kTimeIfSlow may have been too short.
  void note(uid_t owner, Moment now);
  void clear() { slow_until_.clear(); }

 private:
  uid_t own_;
  std::map<uid_t, Moment> slow_until_ = {};
};

}  // namespace ddssec::cli
