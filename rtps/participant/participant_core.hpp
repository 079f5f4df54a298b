// What the parts of one participant share: configuration, time, what they send through, and
// security.
#pragma once

#include "base/event.hpp"
#include "rtps/budget/source_address.hpp"
#include "rtps/participant/ignored_entities.hpp"
#include "rtps/participant/neighbourhood.hpp"
#include "rtps/participant/participant_counters.hpp"
#include "rtps/security/security.hpp"
#include "rtps/transport/interfaces.hpp"

namespace ddssec::rtps {

struct ParticipantConfig {
  GuidPrefix prefix;
  DomainId domain_id = 0;
  std::string domain_tag = {};
  std::string entity_name = {};
  Bytes user_data = {};
  Duration lease_duration{{10, 0}};
  LocatorList metatraffic_unicast = {}, metatraffic_multicast = {}, default_unicast = {};
  /// Of this machine, that lead to others; without any, all addresses of others are taken to do so.
  std::vector<NetworkInterface> interfaces = {};
  /// Where announcements go: multicast groups and the well-known ports of unicast peers.
  std::vector<Locator> announce_to = {};
  /// Of announcements, after the first few, which come quickly; 0: as the lease wants it.
  std::chrono::nanoseconds announcement_period{};
  std::uint32_t fragment_size = MessageSender::kLargestFragment;
  /// Where the entity ids of writers and readers begin, at most kGreatestFirstEntity. A random one
  /// keeps what is said to one process from being taken for what is said to another: submessage
  /// protection covers entity ids, and not the INFO_DST before them.
  std::uint32_t first_entity = 1;
  static constexpr std::uint32_t kGreatestFirstEntity = 0x7fffff;
  /// Random (AmplificationLimit::set_secret).
  std::optional<Sha256Digest> address_secret = {};
  /// Its members are called without the network where nothing is protected. The caller enters the
  /// participant, and calls it with the neighbourhood's lock held.
  std::shared_ptr<Neighbourhood> neighbourhood = {};
};

/// Each part borrows it; it knows no part.
struct ParticipantCore {
  ParticipantCore(ParticipantConfig configuration, Transport& transport, EventSink& sink)
      : config(std::move(configuration)), events(sink), sender(transport, config.prefix) {
    sender.fragment_at(config.fragment_size);
    if (config.address_secret) sender.limit().set_secret(*config.address_secret);
  }

  bool is_authenticated(const GuidPrefix& peer) const {
    return security && security->is_authenticated(peer);
  }
  /// Whose share of a bound a participant takes. DDS-Security 9.3.3: the first half of the prefix
  /// of one that authenticated is bound to the subject of its certificate, the rest it may choose.
  GuidPrefix identity_of(const GuidPrefix& peer) const {
    auto out = peer;
    if (is_authenticated(peer)) std::ranges::fill(std::span(out.octets).subspan(6), 0);
    return out;
  }
  /// See Keyring; nothing without security.
  std::optional<Sha256Digest> keys_of(const EntityId& local, const Guid& remote) const {
    return security ? security->keyring().keys_of(local, remote) : std::nullopt;
  }
  /// Raises an event about a remote participant, or the endpoint of it with that GUID. Who can have
  /// sent what it reports decides whether it counts as the peer's own (peer_event.hpp).
  void raise(Error error, const GuidPrefix& prefix, std::string guid, Origin origin) {
    if (security) return security->core().raise(std::move(error), prefix, std::move(guid), origin);
    events.raise(peer_event(std::move(error), std::move(guid)));
  }
  void raise(Error error, const Guid& guid, Origin origin) {
    raise(std::move(error), guid.prefix, guid.to_string(), origin);
  }
  /// About what is announced of a remote endpoint.
  void raise_about(Error error, const EndpointData& announced) {
    raise(std::move(error), announced.guid,
          origin_of_announcement(announced.guid, announced.by_secure_discovery));
  }
  /// About what a local endpoint was sent by a remote one.
  void raise_about(Error error, const EntityId& local, const Guid& remote) {
    raise(std::move(error), remote,
          security ? security->core().origin(local, remote) : Origin::anyone);
  }
  Origin origin_of_announcement(const Guid& endpoint, bool by_secure_discovery) const {
    return security ? security->core().origin_of_announcement(endpoint, by_secure_discovery)
                    : Origin::anyone;
  }
  /// What the governance says of the domain. Without security: nothing is protected.
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
  MonotonicTime now{};                 ///< of the call that the participant is in
  SourceAddress source{};              ///< of the datagram that is being received
  bool is_from_elsewhere = false;      ///< it came from an address that is not of this machine
  std::unique_ptr<Security> security;  ///< nullptr: it is not secured
};

}  // namespace ddssec::rtps
