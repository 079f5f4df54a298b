#include "rtps/participant/unproven_participants.hpp"

#include <algorithm>
#include <tuple>

namespace ddssec::rtps {

void UnprovenParticipants::add(const SourceAddress& source, const GuidPrefix& prefix,
                               std::size_t octets) {
  auto& share = shares_[source];
  if (share.count == 0) share.since = announcements_;
  ++announcements_;
  ++share.count;
  share.octets += octets;
  octets_ += octets;
  share.silent.push_back(prefix);
  if (share.silent.size() > kMaxSilent) share.silent.pop_front();
}

void UnprovenParticipants::remove(const SourceAddress& source, std::size_t octets) {
  const auto at = shares_.find(source);
  if (at == shares_.end()) return;
  at->second.octets -= octets;
  octets_ -= octets;
  if (--at->second.count == 0) shares_.erase(at);
}

void UnprovenParticipants::grow(const SourceAddress& source, std::size_t more) {
  shares_[source].octets += more;
  octets_ += more;
}

std::optional<SourceAddress> UnprovenParticipants::largest(const SourceAddress& newcomer,
                                                           bool by_octets) const {
  const auto rank = [&](const auto& one) {
    const auto& [source, share] = one;
    const auto held = by_octets ? share.octets : share.count;
    return std::tuple(held, source == newcomer, ~share.since);
  };
  const auto at = std::ranges::max_element(shares_, {}, rank);
  return at == shares_.end() ? std::nullopt : std::optional(at->first);
}

std::optional<GuidPrefix> UnprovenParticipants::oldest_silent(
    const SourceAddress& source, const std::function<bool(const GuidPrefix&)>& is_silent) {
  const auto at = shares_.find(source);
  if (at == shares_.end()) return std::nullopt;
  for (auto& silent = at->second.silent; !silent.empty();) {
    const auto prefix = silent.front();
    silent.pop_front();
    if (is_silent(prefix)) return prefix;
  }
  return std::nullopt;
}

}  // namespace ddssec::rtps
