#include "plugins/access_control/unknown_rights.hpp"

#include <algorithm>

namespace ddssec::access_control {
namespace {

struct OutdatedPeers {
  std::vector<Holder> peers = {};
  std::vector<SharedGrant> seen = {};  // by these peers; each once
};

OutdatedPeers outdated(const std::vector<Holder>& peers) {
  OutdatedPeers out;
  for (const auto& peer : peers) {
    auto seen = peer->outdated_grant_seen();
    if (!seen.grant || seen.must_end) continue;
    out.peers.push_back(peer);
    if (std::ranges::find(out.seen, seen.grant) == out.seen.end())
      out.seen.push_back(std::move(seen.grant));
  }
  return out;
}

}  // namespace

std::optional<std::size_t> find_unknown_right(
    const AccessDecisions& decisions, const PermissionsHolder& own,
    const std::vector<Holder>& peers, std::span<const spi::AccessControl::OwnEndpoint> endpoints) {
  using governance::Action;
  const auto found = outdated(peers);
  if (found.seen.empty()) return std::nullopt;
  const auto unknown = std::ranges::find_if(endpoints, [&](const auto& endpoint) {
    return decisions.is_denied_by_any(
        found.seen, own, endpoint.writes ? Action::publish : Action::subscribe, endpoint.request);
  });
  if (unknown == endpoints.end()) return std::nullopt;
  for (const auto& peer : found.peers) peer->note_must_end();
  return static_cast<std::size_t>(unknown - endpoints.begin());
}

}  // namespace ddssec::access_control
