// Remembers which OCSP responders did not answer the agent.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <sys/types.h>
#include <vector>

namespace ddssec::cli {

/// The OCSP responders that are not asked for a while because they did not answer. Each request to
/// such a responder costs seconds, and the agent looks after one folder at a time. A responder is
/// remembered separately for each owner, because the owner's worker reports it.
class SilentResponders {
 public:
  using Moment = std::chrono::nanoseconds;  ///< of Clock::since_boot
  /// How long a responder is not asked. Shorter than the time after which the agent fetches a
  /// folder's response again.
  static constexpr std::chrono::minutes kLeftAlone{4};
  static constexpr std::size_t kMaxUrls = 16, kMaxOwners = 256;

  /// Notes that the responder did not answer. Does nothing above the limits.
  void note(uid_t owner, std::string url, Moment now);
  /// Returns the responders that are not to be asked for this owner's folders.
  std::vector<std::string> silent_for(uid_t owner, Moment now) const;
  void clear() { silent_.clear(); }

 private:
  std::map<uid_t, std::map<std::string, Moment>> silent_ = {};
};

}  // namespace ddssec::cli
