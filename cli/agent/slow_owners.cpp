#include "cli/agent/slow_owners.hpp"

namespace ddssec::cli {

std::chrono::seconds SlowOwners::time_for(uid_t owner, Moment now) const {
  const auto found = slow_until_.find(owner);
  return found != slow_until_.end() && now < found->second ? kTimeIfSlow : kTime;
}

void SlowOwners::note(uid_t owner, Moment now) {
  if (owner == own_ || time_for(owner, now) == kTimeIfSlow) return;
  slow_until_.insert_or_assign(owner, now + kSlowFor);
}

}  // namespace ddssec::cli
