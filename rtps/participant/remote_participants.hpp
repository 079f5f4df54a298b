// What is known of other participants and their endpoints, and the bounds on it.
#pragma once

#include <array>
#include <map>

#include "rtps/discovery/discovery_listener.hpp"
#include "rtps/participant/endpoint_listener.hpp"
#include "rtps/participant/participant_core.hpp"
#include "rtps/participant/unproven_participants.hpp"

namespace ddssec::rtps {

/// At most four of the `announced` locators that can be sent to, the nearest (keep_nearest);
/// `fallback` if there are none.
LocatorList usable_locators(const LocatorList& announced, const LocatorList& fallback,
                            std::span<const NetworkInterface> own);
/// When the lease of a participant that was heard at `now` ends.
MonotonicTime lease_end(const ParticipantData& data, MonotonicTime now);

struct RemoteEndpoint {
  EndpointData data;
  std::vector<StatefulReader*> readers = {};  ///< of ours, that a writer matched
  std::size_t price = 0;
};

struct RemoteParticipant {
  ParticipantData data;
  LocatorList metatraffic, user;
  MonotonicTime lease_end{};
  MonotonicTime since{};
  MonotonicTime next_question = kNever;  ///< when it is asked whether it lives
  std::map<EntityId, RemoteEndpoint> endpoints = {};
  /// Of its writers with a finite lease, AUTOMATIC and MANUAL_BY_PARTICIPANT, if they are matched.
  std::array<std::shared_ptr<LivelinessSignal>, 2> signals = {};
  /// Local readers of its writers with a finite lease that are MANUAL_BY_TOPIC.
  std::map<EntityId, std::vector<EndpointListener*>> watches = {};
  bool accepted = false;              ///< authenticated, or admitted without
  bool has_signed_addresses = false;  ///< they come from its latest handshake
  bool heard_participants_secure = false;
  std::size_t endpoint_octets = 0;  ///< their price
  bool exceeds = false;             ///< it announced more, and the event was raised
  std::vector<SourceAddress> metatraffic_sources = {}, user_sources = {};  ///< that announced them
  SourceAddress source = {};                 ///< that announced it first
  std::optional<std::size_t> unproven = {};  ///< octets it counts for as long as nothing is proven
  bool exceeds_matches = false;              ///< the same of matches with one endpoint

  const GuidPrefix& prefix() const { return data.guid.prefix; }
  /// nullptr: none of its writers with a finite lease is matched. Not for MANUAL_BY_TOPIC.
  std::shared_ptr<LivelinessSignal>& signal(LivelinessKind kind) {
    return signals[kind == LivelinessKind::automatic ? 0 : 1];
  }
  /// Calls the reader's listener when the writer, with a finite lease, asserts itself.
  void watch(EndpointListener& reader, const EndpointData& writer, MonotonicTime now);
  void stop_watching(EndpointListener& reader, const Guid& writer);
};

/// A table without a protocol: it calls only the DiscoveryListener, and EndpointMatcher matches.
class RemoteParticipants {
 public:
  static constexpr std::size_t kMostParticipants = 512;
  static_assert(Handshakes::kMaxAuthenticated < kMostParticipants, "some are left for newcomers");
  static constexpr std::size_t kMostEndpointsPerParticipant = 16384;
  static constexpr std::size_t kMostEndpoints = 65536;  ///< of all of them
  /// What their announcements take in memory, with a price for each.
  static constexpr std::size_t kMostEndpointOctetsPerParticipant = std::size_t{64} << 20;
  static constexpr std::size_t kMostEndpointOctets = std::size_t{256} << 20;
  static constexpr std::size_t kPricePerEndpoint = 1024;
  /// So much of each participant is kept whatever the others announce.
  static constexpr std::size_t kEndpointOctetsOfEach = std::size_t{256} << 10;
  /// The shortest lease of a peer that is authenticating, whatever is announced in its name.
  static constexpr MonotonicTime kLeastLease = std::chrono::seconds(10);
  /// An authenticated peer that was silent for a third of its lease is asked, and then so often in
  /// a lease that the loss of most questions and answers does not end it.
  static constexpr int kSilentPartOfLease = 3;
  static constexpr int kQuestionsPerLease = 15;

  explicit RemoteParticipants(ParticipantCore& core);

  std::size_t size() const { return remotes_.size(); }
  /// No participant whose announcement takes so many octets can be added.
  bool is_full(std::size_t octets) const;
  const std::map<GuidPrefix, RemoteParticipant>& all() const { return remotes_; }
  /// nullptr: not known.
  RemoteParticipant* find(const GuidPrefix& prefix);
  /// Ourselves, as the other end of our own endpoints.
  RemoteParticipant& self() { return self_; }
  /// Ours too; nullptr: not known.
  RemoteParticipant* find_or_self(const GuidPrefix& prefix);
  RemoteEndpoint* find_endpoint(const Guid& guid);
  /// Who of them authenticated, and what they may.
  const ParticipantCore& core() const { return core_; }

  // Participants.
  /// Adds a participant that is not known, from the source of the datagram that is being received.
  /// Its lease begins now. `octets`: of its announcement.
  RemoteParticipant& add(ParticipantData data, LocatorList metatraffic, LocatorList user,
                         std::size_t octets);
  /// It is announced again, by so many octets. False: there is no room for what is more.
  bool grow(RemoteParticipant& remote, std::size_t octets);
  /// Its endpoints must have been removed.
  void remove(const GuidPrefix& prefix);
  /// The participant that gives way when there is no room: among those that are not authenticated
  /// and came from the source that holds most, the one that announced itself longest ago and sent
  /// no handshake message, else the one that is authenticating for longest. Nothing: all stay.
  std::optional<GuidPrefix> next_to_give_way();
  /// It authenticated, or is admitted without: the DiscoveryListener hears of it.
  void accept(RemoteParticipant& remote);
  /// What it announces changed.
  void on_changed(const RemoteParticipant& remote);

  // Leases.
  /// It was heard now; `data` has its lease duration.
  void renew_lease(RemoteParticipant& remote, const ParticipantData& data);
  /// Its lease ends at `end` unless it is heard before, and it is asked at once.
  void shorten_lease(RemoteParticipant& remote, MonotonicTime end);
  /// Those whose leases have ended.
  std::vector<GuidPrefix> ended();
  /// Authenticated ones that were not heard for a good part of their lease: they are to be asked
  /// for a sign of life. Each comes kQuestionsPerLease times in a lease, less the first part.
  std::vector<GuidPrefix> to_ask();
  /// No lease ends, and no question is due, before.
  MonotonicTime next_end() const { return std::min(next_end_, next_question_); }

  /// Raises an event about what one of their endpoints sent to a local one.
  void raise_about(Error error, const EntityId& local, const Guid& remote) const;

  // Endpoints.
  /// False: the endpoint would exceed a bound, which is counted and once raises an event.
  bool has_room(RemoteParticipant& remote, const EndpointData& endpoint);
  RemoteEndpoint& store(RemoteParticipant& remote, EndpointData data);
  /// It must not be matched any more.
  void remove(RemoteParticipant& remote, const EntityId& id);

  // What the application sees.
  /// Reports to `listener`, from now on and what is known already; nullptr: to none.
  void listen(DiscoveryListener* listener);
  /// Those that were accepted (see DiscoveryListener).
  std::vector<ParticipantData> participants() const;
  std::vector<EndpointData> endpoints() const;
  /// What an endpoint, remote or our own, announced; nullptr if it is not known (any more). Of our
  /// own those are known that have a counterpart here.
  const EndpointData* endpoint(const Guid& guid) const;

 private:
  /// After that share of the lease; never, if it does not end.
  MonotonicTime next_time(const ParticipantData& data, int share) const;
  /// From here on it does not count as unproven.
  void discharge(RemoteParticipant& remote);

  ParticipantCore& core_;
  std::map<GuidPrefix, RemoteParticipant> remotes_;
  RemoteParticipant self_;
  DiscoveryListener* discovery_ = nullptr;
  std::size_t endpoints_ = 0;        ///< of all of them
  std::size_t endpoint_octets_ = 0;  ///< their price
  UnprovenParticipants unproven_;    ///< of a secured participant
  MonotonicTime next_end_ = kNever;
  MonotonicTime next_question_ = kNever;
};

}  // namespace ddssec::rtps
