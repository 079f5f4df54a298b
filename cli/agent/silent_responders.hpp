// What the agent knows of OCSP responders that do not answer.
#pragma once

#include <chrono>
#include <map>
#include <string>
#include <sys/types.h>
#include <vector>

namespace ddssec::cli {

/// Each request to a responder that does not answer costs seconds, and the agent looks after one
/// folder at a time. So a responder that did not answer is left alone for a while. What a folder's
/// owner says of a responder counts for that owner's folders only.
class SilentResponders {
 public:
  using Moment = std::chrono::nanoseconds;  ///< of Clock::since_boot
  /// Shorter than the time after which a folder's response is tried again.
  static constexpr std::chrono::minutes kLeftAlone{4};
  static constexpr std::size_t kMaxUrls = 16, kMaxOwners = 256;

  void note(uid_t owner, std::string url, Moment now);
  std::vector<std::string> of(uid_t owner, Moment now) const;
  void clear() { silent_.clear(); }

 private:
  std::map<uid_t, std::map<std::string, Moment>> silent_ = {};
};

}  // namespace ddssec::cli
