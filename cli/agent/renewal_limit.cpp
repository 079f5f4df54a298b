#include "cli/agent/renewal_limit.hpp"

#include <algorithm>

namespace ddssec::cli {

using std::chrono::seconds;

void RenewalLimit::note(seconds lifetime, Moment now) {
  pause_ = std::clamp(lifetime / 12, seconds(1), seconds(3600));
  used_until_ = std::max(used_until_, now) + pause_;
}

}  // namespace ddssec::cli
