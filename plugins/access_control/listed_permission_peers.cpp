#include "plugins/access_control/listed_permission_peers.hpp"

#include "plugins/access_control/refusals.hpp"

namespace ddssec::access_control {
namespace {

// Extends the permissions of peers. Returns true if a peer ends.
bool follow(const Entries& entries, const PluginServices& services) {
  const WallTime now = services.clock.calendar_seconds();
  bool one_ends = false;
  for (const auto& [handle, holder] : entries) {
    if (!holder->remote()) continue;
    if (const auto listed = holder->follow_list(now))
      services.events.raise(event_about(holder->peer_subject(), *listed));
    one_ends = one_ends || holder->newly_ended(now);
  }
  return one_ends;
}

}  // namespace

void follow_renewal_lists(const Entries& entries, DocumentCache& documents,
                          const PluginServices& services) {
  if (!follow(entries, services)) return;
  for (const auto& [handle, holder] : entries) {
    if (holder->remote()) continue;
    holder->force_poll_of_list();
    for (const auto& event : holder->renew(documents, services.clock))
      services.events.raise(event_about({}, event));
  }
  follow(entries, services);
}

}  // namespace ddssec::access_control
