#include "plugins/authentication/remote_counts.hpp"

#include <algorithm>

namespace ddssec::authentication {
namespace {

std::unexpected<Error> too_many_error(std::size_t limit, std::string_view of_what) {
  return fail(Code::too_many_remote_identities,
              {.expected = "at most " + std::to_string(limit) + " that " + std::string(of_what),
               .found = "one more"});
}

}  // namespace

RemoteCounts::Half RemoteCounts::half_of(const Guid& guid) {
  Half half;
  std::copy_n(guid.prefix.octets.begin(), half.size(), half.begin());
  return half;
}

Status RemoteCounts::check_claim(const Guid& guid, const RemoteLimits& limits) const {
  if (claimed_ >= limits.max_claimed)
    return too_many_error(limits.max_claimed, "have not authenticated");
  return check_authenticated(guid, limits);
}

Status RemoteCounts::check_authenticated(const Guid& guid, const RemoteLimits& limits) const {
  if (authenticated_ >= limits.max_authenticated)
    return too_many_error(limits.max_authenticated, "have authenticated");
  const auto known = subjects_.find(half_of(guid));
  if (known == subjects_.end()) return {};
  const auto& subject = known->second;
  const auto free = limits.max_authenticated - authenticated_;
  const auto limit = std::min(limits.max_of_a_subject, free);
  if (subject.count < limit) return {};
  const bool is_crowded = limit < limits.max_of_a_subject;
  return fail(Code::too_many_identities_of_subject,
              {.document = "the certificate of " + subject.name,
               .expected = "at most " + std::to_string(limit) + " participants" +
                           (is_crowded ? ", as many as places are free" : ""),
               .found = "one more than " + std::to_string(subject.count)});
}

void RemoteCounts::authenticate(const Guid& guid, std::string subject) {
  auto& counted = subjects_[half_of(guid)];
  counted.name = std::move(subject);
  ++counted.count;
  ++authenticated_;
  --claimed_;
}

void RemoteCounts::remove(const Guid& guid, bool authenticated) {
  if (!authenticated) {
    --claimed_;
    return;
  }
  --authenticated_;
  const auto subject = subjects_.find(half_of(guid));
  if (--subject->second.count == 0) subjects_.erase(subject);
}

}  // namespace ddssec::authentication
