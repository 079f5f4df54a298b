// The objects that the parts of one participant share: configuration, time, sender and security.
#pragma once

#include <algorithm>

#include "base/event.hpp"
#include "rtps/budget/source_address.hpp"
#include "rtps/participant/ignored_entities.hpp"
#include "rtps/participant/participant_counters.hpp"
#include "rtps/participant/process_peers.hpp"
#include "rtps/security/security.hpp"
#include "rtps/transport/network_interfaces.hpp"

namespace ddssec::rtps {

/// What is fixed about this participant when it is created.
struct ParticipantConfig {
  GuidPrefix prefix;
  DomainId domain_id = 0;
  std::string domain_tag = {};
  std::string entity_name = {};
  Bytes user_data = {};
  Duration lease_duration{{10, 0}};
  LocatorList metatraffic_unicast = {}, metatraffic_multicast = {}, default_unicast = {};
  /// The interfaces of this machine that reach other participants. If there are none, all remote
  /// addresses are considered reachable.
  std::vector<NetworkInterface> interfaces = {};
  /// The destinations of announcements: multicast groups, and the well-known ports of unicast
  /// peers.
  std::vector<Locator> announce_to = {};
  /// Time between announcements, after the first few, which follow quickly. If it is 0, it is
  /// derived from the lease duration.
  std::chrono::nanoseconds announcement_period{};
  std::uint32_t fragment_size = MessageSender::kMaxFragment;
  /// The first entity id of writers and readers, at most kMaxFirstEntity. A random value
  /// prevents a message for one process from being accepted by another: submessage protection
  /// covers entity ids, but not the INFO_DST before them.
  std::uint32_t first_entity = 1;
  static constexpr std::uint32_t kMaxFirstEntity = 0x7fffff;
  /// A random secret (AmplificationLimit::set_secret).
  std::optional<Sha256Digest> address_secret = {};
  /// The other participants of this process, whose endpoints are called without the network if
  /// nothing is protected. The caller adds the participant to the process peers, and holds their
  /// lock during all calls.
  std::shared_ptr<ProcessPeers> process_peers = {};
};

/// The state that all parts use. It does not know the parts.
struct ParticipantCore {
  ParticipantCore(ParticipantConfig configuration, Transport& transport, EventSink& sink)
      : config(std::move(configuration)), events(sink), sender(transport, config.prefix) {
    sender.fragment_at(config.fragment_size);
    if (config.address_secret) sender.amplification_limit().set_secret(*config.address_secret);
  }

  bool is_authenticated(const GuidPrefix& peer) const {
    return security && security->is_authenticated(peer);
  }
  /// Returns the identity whose share of a limit a participant uses. For an authenticated
  /// participant, the first half of the prefix is bound to the subject of its certificate
  /// (DDS-Security 1.2, clause 10.3.3). The participant may choose the rest, so the rest is
  /// ignored.
  GuidPrefix identity_of(const GuidPrefix& peer) const {
    auto out = peer;
    if (is_authenticated(peer)) std::ranges::fill(std::span(out.octets).subspan(6), 0);
    return out;
  }
  /// Returns the subject of the participant's certificate; empty if it has not authenticated.
  std::string subject_of(const GuidPrefix& peer) const {
    const auto* known = security ? security->core().find(peer) : nullptr;
    return known == nullptr ? "" : security->core().proven_subject(*known).value_or("");
  }
  /// Returns the address without its port. All addresses of this machine are one host.
  Locator host_of(const Locator& address) const;
  /// Returns the digest of the keys (see Keyring); empty without security.
  std::optional<Sha256Digest> keys_of(const EntityId& local, const Guid& remote) const {
    return security ? security->keyring().keys_of(local, remote) : std::nullopt;
  }
  /// Raises an event about a remote participant, or about its endpoint with that GUID. `origin`
  /// says who can have sent the data in question. So it decides whether the event names the peer as
  /// proven (peer_event.hpp).
  void raise(Error error, const GuidPrefix& prefix, std::string guid, EventOrigin origin) {
    if (security) return security->core().raise(std::move(error), prefix, std::move(guid), origin);
    events.raise(peer_event(std::move(error), std::move(guid)));
  }
  void raise(Error error, const Guid& guid, EventOrigin origin) {
    raise(std::move(error), guid.prefix, guid.to_string(), origin);
  }
  /// Raises an event about the announcement of a remote endpoint.
  void raise_about(Error error, const EndpointData& announced) {
    raise(std::move(error), announced.guid,
          origin_of_announcement(announced.guid, announced.by_secure_discovery));
  }
  /// Raises an event about data that a remote endpoint sent to a local one.
  void raise_about(Error error, const EntityId& local, const Guid& remote) {
    raise(std::move(error), remote,
          security ? security->core().origin(local, remote) : EventOrigin::anyone);
  }
  EventOrigin origin_of_announcement(const Guid& endpoint, bool by_secure_discovery) const {
    return security ? security->core().origin_of_announcement(endpoint, by_secure_discovery)
                    : EventOrigin::anyone;
  }
  /// True if only its participant can have announced the endpoint.
  bool is_proven(const EndpointData& announced) const {
    return origin_of_announcement(announced.guid, announced.by_secure_discovery) ==
           EventOrigin::its_keys;
  }
  /// True if only that participant can have sent the data of its DCPSParticipantsSecure.
  bool is_participant_data_proven(const GuidPrefix& peer) const {
    return security &&
           security->core().origin(kParticipantsSecureReader, {peer, kParticipantsSecureWriter}) ==
               EventOrigin::its_keys;
  }
  /// Returns the governance's attributes of the domain. Without security, nothing is protected.
  const spi::ParticipantSecurityAttributes& attributes() const {
    static const spi::ParticipantSecurityAttributes kNone;
    return security ? security->own().attributes() : kNone;
  }

  ParticipantConfig config;
  EventSink& events;
  MessageSender sender;
  TimerQueue timers;
  ParticipantCounters counters;
  IgnoredEntities ignored;
  MonotonicTime now{};     ///< time of the current call
  SourceAddress source{};  ///< source of the datagram that is being received
  /// Addresses of this machine when a peer last authenticated, without ports.
  LocatorList own_addresses{};
  Locator source_host{};               ///< host_of(source); invalid while no datagram is received
  bool is_from_elsewhere = false;      ///< true if the datagram came from another machine's address
  std::unique_ptr<Security> security;  ///< nullptr without security
};

inline Locator ParticipantCore::host_of(const Locator& address) const {
  const Locator host{address.kind, 0, address.address};
  const bool is_here =
      address.is_loopback() || std::ranges::find(own_addresses, host) != own_addresses.end();
  return is_here ? Locator::udp_v4({127, 0, 0, 1}, 0) : host;
}

}  // namespace ddssec::rtps
