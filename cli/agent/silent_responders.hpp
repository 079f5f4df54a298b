// Which OCSP responders did not answer the agent.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <sys/types.h>
#include <vector>

namespace ddssec::cli {

/// Each request to a responder that does not answer costs seconds, and the agent looks after one
/// folder at a time. So a responder that did not answer is not asked for a while. It is remembered
/// separately for each owner, because the owner's worker reports it.
class SilentResponders {
 public:
  using Moment = std::chrono::nanoseconds;  ///< of Clock::since_boot
  /// Shorter than the time after which the agent fetches a folder's response again.
  static constexpr std::chrono::minutes kLeftAlone{4};
  static constexpr std::size_t kMaxUrls = 16, kMaxOwners = 256;

  void note(uid_t owner, std::string url, Moment now);
  std::vector<std::string> of(uid_t owner, Moment now) const;
  void clear() { silent_.clear(); }

 private:
  std::map<uid_t, std::map<std::string, Moment>> silent_ = {};
};

}  // namespace ddssec::cli
