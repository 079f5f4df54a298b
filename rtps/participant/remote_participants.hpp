// The known remote participants and their endpoints, and the limits for them.
#pragma once

#include <algorithm>
#include <array>
#include <map>
#include <set>

#include "rtps/budget/announced_shares.hpp"
#include "rtps/budget/work_budget.hpp"
#include "rtps/discovery/discovery_listener.hpp"
#include "rtps/participant/announcement_refresh.hpp"
#include "rtps/participant/clear_addresses.hpp"
#include "rtps/participant/endpoint_listener.hpp"
#include "rtps/participant/participant_core.hpp"
#include "rtps/participant/proven_hosts.hpp"
#include "rtps/participant/unproven_participants.hpp"

namespace ddssec::rtps {

/// Returns at most four of the `announced` locators that can be sent to, the nearest ones
/// (keep_nearest), or `fallback` if there are none.
LocatorList usable_locators(const LocatorList& announced, const LocatorList& fallback,
                            std::span<const NetworkInterface> own);
/// An endpoint that a remote participant announced.
struct RemoteEndpoint {
  EndpointData data;
  std::vector<StatefulReader*> readers = {};  ///< the local readers that this writer matched
  std::size_t price = 0;
  bool is_proven = false;  ///< true if only its participant can have announced it
};

/// A remote participant that is known, with or without authentication.
struct RemoteParticipant {
  ParticipantData data;
  LocatorList metatraffic, user;  ///< the addresses that are used
  MonotonicTime lease_end{};
  MonotonicTime since{};
  MonotonicTime next_query = kNever;  ///< when it is next queried whether it is alive
  std::map<EntityId, RemoteEndpoint> endpoints = {};
  /// The signals for its matched writers with a finite lease, of kind AUTOMATIC and
  /// MANUAL_BY_PARTICIPANT.
  std::array<std::shared_ptr<LivelinessSignal>, 2> signals = {};
  /// The listeners of the local readers of its MANUAL_BY_TOPIC writers with a finite lease.
  std::map<EntityId, std::vector<EndpointListener*>> watches = {};
  /// True if it was dormant in this session (DormantPeers). The counts of its endpoints restarted,
  /// so recordings look new to all of them but its volatile secure writer and reader.
  bool has_returned = false;
  bool accepted = false;              ///< authenticated, or admitted without authentication
  bool has_signed_addresses = false;  ///< its addresses come from its latest handshake
  /// The addresses that it has after a handshake, and its hosts that are proven.
  LocatorList signed_metatraffic = {}, signed_user = {};
  WorkBudget moves{4, std::chrono::seconds(1), {}};  ///< to other addresses under its keys
  /// The addresses that it announced last under its keys, if it has moved too often (follow).
  std::optional<std::pair<LocatorList, LocatorList>> next_addresses = {};
  ProvenHosts hosts = {};
  ProvenHosts doubted_hosts = {};        ///< see switch_doubted_hosts
  bool has_displaced_addresses = false;  ///< messages also went to addresses that are not known now
  bool heard_participants_secure = false;
  bool marks_ends = false;  ///< it signed kMarksEndsProperty
  /// What its endpoints cost: [0] those that anyone can have announced, [1] those that are proven.
  std::array<AnnouncedShares::Amount, 2> announced = {};
  GuidPrefix account = {};  ///< the identity that its endpoints count for
  /// [i]: it announced more than the limit of announced[i], and the event was raised.
  std::array<bool, 2> exceeds = {};
  /// The sources that announced these locators.
  std::vector<SourceAddress> metatraffic_sources = {}, user_sources = {};
  SourceAddress source = {};                 ///< the source that announced the participant first
  std::optional<std::size_t> unproven = {};  ///< octets it counts for while nothing is proven
  /// True if it exceeded the limit of matches with one endpoint, and the event was raised.
  bool exceeds_matches = false;
  /// True if it announced an endpoint at hosts that are not proven, and the event was raised.
  bool has_unproven_endpoints = false;
  AnnouncementRefresh announcement_refresh = {};
  MonotonicTime next_offer = kNever;  ///< when our plain announcements are next offered to it
  /// Endpoints that it has not announced again since that is protected (ProvenRefreshes).
  std::set<EntityId> unconfirmed = {};
  /// The addresses that its clear announcements add to its own ones.
  ClearAddresses clear_addresses = {};
  /// True if these would have been more than the limit, and the event was raised.
  bool exceeds_addresses = false;

  const GuidPrefix& prefix() const { return data.guid.prefix; }
  /// Returns the slot of the signal for writers of this kind. It holds nullptr if no such writer
  /// with a finite lease is matched. Not for MANUAL_BY_TOPIC.
  std::shared_ptr<LivelinessSignal>& signal(LivelinessKind kind) {
    return signals[kind == LivelinessKind::automatic ? 0 : 1];
  }
  /// Calls the reader's listener when this writer, which has a finite lease, asserts its
  /// liveliness.
  void watch(EndpointListener& reader, const EndpointData& writer, MonotonicTime now);
  void stop_watching(EndpointListener& reader, const Guid& writer);
};

/// A table without protocol logic. It calls only the DiscoveryListener; EndpointMatcher does the
/// matching.
class RemoteParticipants {
 public:
  static constexpr std::size_t kMaxParticipants = 512;
  /// How many participants whose leases ended together are handled before other work. An attacker
  /// chooses the leases of invented ones.
  static constexpr std::size_t kMaxEndsAtOnce = 64;
  static_assert(Handshakes::kMaxAuthenticated < kMaxParticipants, "some are left for newcomers");
  /// The limits for endpoints hold once for those that are proven (ParticipantCore::is_proven), and
  /// once for those that anyone can have announced: these cannot use up the room of the others.
  static constexpr std::size_t kMaxEndpointsPerParticipant = 16384;
  /// Limit for all participants together. One identity gets no more than is free.
  static constexpr std::size_t kMaxEndpoints = 65536;
  /// The limits for the memory of announcements, including a fixed price for each endpoint.
  static constexpr std::size_t kMaxEndpointOctetsPerParticipant = std::size_t{64} << 20;
  static constexpr std::size_t kMaxEndpointOctets = std::size_t{256} << 20;
  static constexpr std::size_t kPricePerEndpoint = 1024;
  /// The octets of each participant that are kept whatever the others announce.
  static constexpr std::size_t kEndpointOctetsOfEach = std::size_t{256} << 10;
  /// The longest lease that a secured participant gives, whatever is announced: a peer that is
  /// alive answers the queries, and one that is gone does not stay for good.
  static constexpr MonotonicTime kMaxLease = std::chrono::minutes(5);
  /// The shortest lease of a peer that is authenticating, whatever is announced in its name.
  static constexpr MonotonicTime kMinLease = std::chrono::seconds(10);
  /// An authenticated peer that is silent for a third of its lease is queried. The queries are so
  /// frequent that losing most queries and answers does not end the lease.
  static constexpr int kSilentPartOfLease = 3;
  static constexpr int kQueriesPerLease = 15;
  /// The shortest time between two queries of a peer, however short a lease is announced.
  static constexpr MonotonicTime kMinPause = std::chrono::milliseconds(100);
  /// The pause before a participant that is not queried is checked again: it may have
  /// authenticated.
  static constexpr MonotonicTime kPauseOfUnproven = std::chrono::seconds(1);

  explicit RemoteParticipants(ParticipantCore& core);

  std::size_t size() const { return remotes_.size(); }
  /// True if no participant whose announcement has this many octets can be added.
  bool is_full(std::size_t octets) const;
  const std::map<GuidPrefix, RemoteParticipant>& all() const { return remotes_; }
  /// Returns nullptr if the participant is not known.
  RemoteParticipant* find(const GuidPrefix& prefix);
  /// Returns the local participant, as the remote side of its own endpoints.
  RemoteParticipant& self() { return self_; }
  /// Also finds the local participant. Returns nullptr if the participant is not known.
  RemoteParticipant* find_or_self(const GuidPrefix& prefix);
  RemoteEndpoint* find_endpoint(const Guid& guid);
  /// Returns the core, to check which participants authenticated, and what they may do.
  const ParticipantCore& core() const { return core_; }

  // Participants:
  /// Adds an unknown participant, from the source of the datagram that is being received. Its lease
  /// begins now. `octets` is the size of its announcement.
  RemoteParticipant& add(ParticipantData data, LocatorList metatraffic, LocatorList user,
                         std::size_t octets);
  /// Notes that its announcement has grown by this many octets. Returns false if there is no room
  /// for them.
  bool grow(RemoteParticipant& remote, std::size_t octets);
  /// Removes a participant. Its endpoints must have been removed before.
  void remove(const GuidPrefix& prefix);
  /// Adds a participant as it was known before, but without endpoints, and not yet accepted. Its
  /// lease begins now.
  RemoteParticipant& restore(RemoteParticipant known);
  /// Returns the participant to remove when there is no room. Candidates are not authenticated and
  /// came from the source that holds the most. First choice: the one that announced itself longest
  /// ago and sent no handshake message. Second choice: the one that has been authenticating for the
  /// longest time. Empty: none is removed.
  std::optional<GuidPrefix> next_to_evict();
  /// Accepts a participant that authenticated, or is admitted without authentication. Reports it to
  /// the DiscoveryListener.
  void accept(RemoteParticipant& remote);
  /// Reports that its announced data changed.
  void on_changed(const RemoteParticipant& remote);

  // Leases:
  /// Notes that the participant was heard now; `data` contains its lease duration.
  void renew_lease(RemoteParticipant& remote, const ParticipantData& data);
  /// What is due now. Authenticated participants that were silent for a third of their lease must
  /// be queried; each is named at kQueriesPerLease per lease from then on. At most kMaxEndsAtOnce
  /// leases that have ended are named. If there are more, next_end() is now.
  struct Due {
    std::vector<GuidPrefix> queries, ended_leases;
  };
  Due take_due();
  /// Returns a time before which no lease ends and no query is due.
  MonotonicTime next_end() const { return std::min(next_end_, next_query_); }

  /// Raises an event about what a remote endpoint sent to a local one.
  void raise_about(Error error, const EntityId& local, const Guid& remote) const;

  // Endpoints:
  /// Returns false if the endpoint would exceed a limit. This is counted, and an event is raised
  /// once.
  bool has_room(RemoteParticipant& remote, const EndpointData& endpoint);
  RemoteEndpoint& store(RemoteParticipant& remote, EndpointData data);
  /// Removes an endpoint. It must not be matched any more.
  void remove(RemoteParticipant& remote, const EntityId& id);

  // For the application:
  /// Reports to `listener` what is already known, and everything from now on. With nullptr, stops
  /// reporting.
  void set_discovery_listener(DiscoveryListener* listener);
  /// Returns the participants that were accepted (see DiscoveryListener).
  std::vector<ParticipantData> participants() const;
  std::vector<EndpointData> endpoints() const;
  /// Returns the announcement of a remote or local endpoint; nullptr if it is not known (any more).
  /// Local endpoints are known only if they match another local endpoint.
  const EndpointData* endpoint(const Guid& guid) const;

 private:
  /// Returns the time after this share of the lease, or after kMinPause if that is later; kNever if
  /// the lease does not end.
  MonotonicTime next_time(const ParticipantData& data, int share) const;
  /// Stops counting the participant as unproven.
  void discharge(RemoteParticipant& remote);

  ParticipantCore& core_;
  std::map<GuidPrefix, RemoteParticipant> remotes_;
  RemoteParticipant self_;
  DiscoveryListener* discovery_ = nullptr;
  static constexpr AnnouncedShares::Amount kMaxAnnounced{kMaxEndpointOctets, kMaxEndpoints};
  /// Both are in the order of RemoteParticipant::announced.
  std::array<AnnouncedShares, 2> announced_{AnnouncedShares(kMaxAnnounced),
                                            AnnouncedShares(kMaxAnnounced)};
  UnprovenParticipants unproven_;  ///< only used by a secured participant
  MonotonicTime next_end_ = kNever;
  MonotonicTime next_query_ = kNever;
};

/// What add_locators changed.
struct AddedLocators {
  bool has_new = false;        ///< any of them is new
  bool has_displaced = false;  ///< others had to go
};
/// Adds locators that `source` announced to `known`; `sources` has the source of each. At most
/// eight are kept, and the locators that one source announces do not displace those that other
/// sources announced.
AddedLocators add_locators(LocatorList& known, std::vector<SourceAddress>& sources,
                           const LocatorList& more, const SourceAddress& source);

}  // namespace ddssec::rtps
