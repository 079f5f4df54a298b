#include "rtps/participant/remote_addresses.hpp"

#include <fmt/format.h>

namespace ddssec::rtps {
namespace {

bool cannot_be_sent_to(const Locator& locator) {
  return !locator.is_usable() || locator.is_multicast();
}

bool has_signed(const RemoteParticipant& remote) { return !remote.signed_metatraffic.empty(); }

bool has_signed_host(const ParticipantCore& core, const RemoteParticipant& remote,
                     const Locator& host) {
  const auto is_there = [&](const Locator& address) { return core.host_of(address) == host; };
  return std::ranges::any_of(remote.signed_metatraffic, is_there) ||
         std::ranges::any_of(remote.signed_user, is_there);
}

LocatorList only_proven(const ParticipantCore& core, const RemoteParticipant& remote,
                        const LocatorList& announced) {
  LocatorList out;
  for (const auto& locator : announced)
    if (remote.hosts.contains(core.host_of(locator))) out.push_back(locator);
  return out;
}

// Returns the participant's ports at the hosts from which it was heard. They are needed because a
// participant behind a router, or with a second address that it never sends from, signs none of
// these addresses.
LocatorList at_hosts(const RemoteParticipant& remote, const LocatorList& announced) {
  LocatorList out;
  for (const auto& host : remote.hosts.all())
    for (const auto& locator : announced) {
      if (locator.kind != host.kind) continue;
      const Locator address{host.kind, locator.port, host.address};
      if (std::ranges::find(out, address) == out.end()) out.push_back(address);
    }
  return out;
}

// Returns the addresses at proven hosts. If there are none, returns the same ports at these hosts.
LocatorList proven_of(const ParticipantCore& core, const RemoteParticipant& remote,
                      const LocatorList& announced) {
  auto out = only_proven(core, remote, announced);
  return out.empty() ? at_hosts(remote, announced) : out;
}

// Returns the host of all addresses to which anything was sent; invalid if it was not one host.
Locator only_host(const ParticipantCore& core, const RemoteParticipant& remote) {
  const auto& addresses = remote.metatraffic;
  if (addresses.empty() || remote.has_displaced_addresses) return {};
  const auto host = core.host_of(addresses.front());
  const auto same = [&](const Locator& address) { return core.host_of(address) == host; };
  return std::ranges::all_of(addresses, same) ? host : Locator{};
}

void settle(const ParticipantCore& core, RemoteParticipant& remote) {
  const auto& own = core.config.interfaces;
  const auto proven = usable_locators(proven_of(core, remote, remote.signed_metatraffic), {}, own);
  remote.user = usable_locators(proven_of(core, remote, remote.signed_user), proven, own);
  remote.metatraffic =
      proven.empty() ? usable_locators(remote.signed_metatraffic, {}, own) : proven;
  remote.user_sources.assign(remote.user.size(), remote.source);
  remote.metatraffic_sources.assign(remote.metatraffic.size(), remote.source);
}

// True if the address is at a host of the participant. A participant that signed nothing is limited
// by other means, so all its addresses are trusted.
bool is_at_its_hosts(const ParticipantCore& core, const RemoteParticipant& remote,
                     const Locator& address) {
  const auto host = core.host_of(address);
  if (has_signed(remote)) return remote.hosts.contains(host);
  const auto same = [&](const Locator& other) { return core.host_of(other) == host; };
  return std::ranges::any_of(remote.user, same) || std::ranges::any_of(remote.metatraffic, same);
}

std::string text_of(const LocatorList& locators) {
  std::string out;
  for (const auto& locator : locators) out += (out.empty() ? "" : ", ") + to_string(locator);
  return out.empty() ? "none" : out;
}

// Returns the hosts as text, without their ports.
std::string text_of_hosts(const ParticipantCore& core, const RemoteParticipant& remote) {
  std::string out;
  for (const auto& host : has_signed(remote) ? remote.hosts.all() : remote.metatraffic) {
    const auto text = to_string(core.host_of(host));
    out += (out.empty() ? "" : ", ") + text.substr(0, text.rfind(':'));
  }
  return out.empty() ? "none" : out;
}

void report_unproven(ParticipantCore& core, RemoteParticipant& remote,
                     const EndpointData& endpoint) {
  if (std::exchange(remote.has_unproven_endpoints, true)) return;
  core.raise_about(
      Error(Code::rtps_address_unproven,
            {.document = "topic " + endpoint.topic_name,
             .field = "unicast locator of " + endpoint.guid.to_string(),
             .expected = "an address at the hosts where its participant was heard or answered: " +
                         text_of_hosts(core, remote),
             .found = text_of(endpoint.unicast),
             .note = "messages to it go to " + text_of(remote.user) +
                     "; no further event about endpoints of this participant follows"}),
      endpoint);
}

void report_too_many(ParticipantCore& core, RemoteParticipant& remote, const EndpointData& endpoint,
                     const Locator& address) {
  if (std::exchange(remote.exceeds_addresses, true)) return;
  core.raise_about(
      Error(Code::rtps_too_many_addresses,
            {.document = "topic " + endpoint.topic_name,
             .field = "unicast locator of " + endpoint.guid.to_string(),
             .expected = fmt::format("at most {} addresses beside those of its participant",
                                     ClearAddresses::kMax),
             .found = to_string(address),
             .note = "no further event about the addresses of this participant follows"}),
      endpoint);
}

bool is_own(const RemoteParticipant& remote, const Locator& address) {
  const auto has = [&](const LocatorList& list) {
    return std::ranges::find(list, address) != list.end();
  };
  return has(remote.user) || has(remote.metatraffic) || has(remote.signed_user) ||
         has(remote.signed_metatraffic);
}

// Returns the addresses that the endpoint may use, although anyone can have announced it.
LocatorList within_limit(ParticipantCore& core, RemoteParticipant& remote,
                         const EndpointData& endpoint, const LocatorList& addresses) {
  LocatorList out;
  for (const auto& address : addresses) {
    if (is_own(remote, address) || remote.clear_addresses.use(address, endpoint.guid.entity))
      out.push_back(address);
    else
      report_too_many(core, remote, endpoint, address);
  }
  return out;
}

}  // namespace

bool adopt_signed_addresses(ParticipantCore& core, RemoteParticipant& remote,
                            LocatorList metatraffic, LocatorList user) {
  std::erase_if(metatraffic, cannot_be_sent_to);
  std::erase_if(user, cannot_be_sent_to);
  const bool any = !metatraffic.empty();
  if (!core.config.interfaces.empty()) core.own_addresses = addresses_of_this_machine();
  // The messages of the handshake went to these addresses, and the peer answered them.
  const auto answered = only_host(core, remote);
  remote.signed_metatraffic = metatraffic.empty() ? remote.metatraffic : std::move(metatraffic);
  remote.signed_user = user.empty() ? remote.user : std::move(user);
  remote.hosts.keep([&](const Locator& host) { return has_signed_host(core, remote, host); });
  remote.hosts.add(answered);
  remote.doubted_hosts = {};
  for (const auto& address : remote.signed_metatraffic)
    if (core.sender.amplification_limit().is_proven(remote.prefix(), address))
      remote.hosts.add(core.host_of(address));
  remote.hosts.add(core.host_of(core.source_host));  // own_addresses was just read again
  settle(core, remote);
  return any;
}

bool prove_host(const ParticipantCore& core, RemoteParticipant& remote, const Locator& host) {
  if (!has_signed(remote) || !remote.hosts.add(host)) return false;
  settle(core, remote);
  return true;
}

bool switch_doubted_hosts(const ParticipantCore& core, RemoteParticipant& remote) {
  const bool any = !remote.hosts.all().empty() || !remote.doubted_hosts.all().empty();
  if (!has_signed(remote) || !any || !only_proven(core, remote, remote.signed_metatraffic).empty())
    return false;
  std::swap(remote.hosts, remote.doubted_hosts);
  settle(core, remote);
  return true;
}

bool choose_addresses_of(const ParticipantCore& core, RemoteParticipant& remote) {
  const auto former = std::pair(remote.metatraffic, remote.user);
  if (has_signed(remote)) {
    settle(core, remote);
  } else if (remote.accepted) {
    const auto& own = core.config.interfaces;
    remote.metatraffic = usable_locators(remote.data.metatraffic_unicast, remote.metatraffic, own);
    remote.user = usable_locators(remote.data.default_unicast, remote.metatraffic, own);
    remote.metatraffic_sources.assign(remote.metatraffic.size(), remote.source);
    remote.user_sources.assign(remote.user.size(), remote.source);
  }
  return former != std::pair(remote.metatraffic, remote.user);
}

bool has_proven_address(const ParticipantCore& core, const RemoteParticipant& remote) {
  return !has_signed(remote) || std::ranges::any_of(remote.metatraffic, [&](const auto& address) {
    return remote.hosts.contains(core.host_of(address));
  });
}

LocatorList addresses_of(ParticipantCore& core, RemoteParticipant& remote,
                         const EndpointData& endpoint) {
  const auto& own = core.config.interfaces;
  if (remote.prefix() == core.config.prefix)
    return usable_locators(endpoint.unicast, remote.user, own);
  LocatorList out;
  bool any = false;
  for (const auto& locator : endpoint.unicast) {
    if (cannot_be_sent_to(locator)) continue;
    any = true;
    if (is_at_its_hosts(core, remote, locator)) out.push_back(locator);
  }
  if (any && out.empty()) report_unproven(core, remote, endpoint);
  auto used = usable_locators(out, {}, own);
  if (core.security && !core.is_proven(endpoint)) {
    used = within_limit(core, remote, endpoint, used);
    // A forged announcement must not keep samples from reaching the participant itself.
    for (const auto& address : remote.user)
      if (std::ranges::find(used, address) == used.end()) used.push_back(address);
  }
  return used.empty() ? remote.user : used;
}

}  // namespace ddssec::rtps
