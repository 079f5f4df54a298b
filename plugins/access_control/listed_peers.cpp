#include "plugins/access_control/listed_peers.hpp"

#include "plugins/access_control/refusals.hpp"

namespace ddssec::access_control {
namespace {

/// True: a peer ends.
bool follow(const Entries& entries, const Environment& environment) {
  const WallTime now = environment.clock.now();
  bool one_ends = false;
  for (const auto& [handle, holder] : entries) {
    if (!holder->remote()) continue;
    if (const auto listed = holder->follow_list(now))
      environment.events.raise(event_about(holder->peer_subject(), *listed));
    one_ends = one_ends || holder->newly_ended(now);
  }
  return one_ends;
}

}  // namespace

void follow_renewal_lists(const Entries& entries, DocumentCache& documents,
                          const Environment& environment) {
  if (!follow(entries, environment)) return;
  for (const auto& [handle, holder] : entries) {
    if (holder->remote()) continue;
    holder->look_at_list_now();
    for (const auto& event : holder->renew(documents, environment.clock))
      environment.events.raise(event_about({}, event));
  }
  follow(entries, environment);
}

}  // namespace ddssec::access_control
