// What leads from this participant to those that discovery has found.
#pragma once

#include <utility>

#include "rtps/participant/builtin_matcher.hpp"
#include "rtps/participant/endpoint_matcher.hpp"
#include "rtps/participant/remote_addresses.hpp"

namespace ddssec::rtps {

/// Accepts and removes found participants, and keeps up to date where each is sent to, how much it
/// may be sent, and which of its endpoints are matched. Discovery decides when.
class ParticipantLinks final : private TimedObject {
 public:
  /// The pause before addresses are followed that a participant announces too often.
  static constexpr MonotonicTime kMovePause = std::chrono::seconds(1);

  ParticipantLinks(ParticipantCore& core, RemoteParticipants& remotes, EndpointMatcher& matcher,
                   BuiltinMatcher& builtin)
      : TimedObject(core.timers),
        core_(core),
        remotes_(remotes),
        matcher_(matcher),
        builtin_(builtin) {}

  /// Accepts a participant that authenticated, or is admitted without authentication. From now on
  /// its builtin endpoints may match. If it returns, the facts known about it still count.
  void accept(RemoteParticipant& remote, bool returns = false) {
    remotes_.accept(remote);
    builtin_.match(remote, returns);
  }
  /// Removes a participant, as if it had never been found.
  void remove(const GuidPrefix& prefix) {
    auto* remote = remotes_.find(prefix);
    if (remote == nullptr) return;
    unmatch(*remote);
    const auto reset = core_.security ? core_.security->lost(prefix) : std::nullopt;
    // An ignored participant gets none: its host would restart all its sessions with us.
    if (reset && !core_.ignored.contains(prefix))
      core_.sender.send_alone(*reset, remote->metatraffic);
    core_.sender.flush_now();  // before the limit is lifted, because waiting messages count for it
    core_.sender.amplification_limit().end(prefix);
    remotes_.remove(prefix);
  }
  /// Removes others until there is room for a participant whose announcement has this many octets.
  /// Returns false if that is not possible.
  bool make_room(std::size_t octets) {
    while (remotes_.is_full(octets)) {
      const auto prefix = remotes_.next_to_evict();
      if (!prefix) return false;
      ++core_.counters.refused_discovery;
      remove(*prefix);
    }
    return true;
  }
  void unmatch(RemoteParticipant& remote) {
    matcher_.remove_all(remote);
    builtin_.unmatch(remote);
  }
  /// Limits what is sent to the participant, unless an address of it is proven.
  void limit_until_proven(const RemoteParticipant& remote) {
    if (!has_proven_address(core_, remote))
      core_.sender.amplification_limit().begin(remote.prefix(), remote.metatraffic,
                                               remote.metatraffic_sources);
  }
  /// Sends to the addresses that were chosen last: those of a proven host, if there is one.
  void readdress(RemoteParticipant& remote) {
    if (has_proven_address(core_, remote)) core_.sender.amplification_limit().end(remote.prefix());
    if (core_.security) core_.security->readdress(remote.prefix(), remote.metatraffic);
    builtin_.readdress(remote, core_.now);
    matcher_.readdress(remote);
  }
  /// Follows the participant to addresses that it announces under its keys. They count like those
  /// that it signed in a handshake. Does nothing where nothing protects DCPSParticipantsSecure,
  /// because anyone can have announced them. Each move costs time for each endpoint of the
  /// participant. So if it moves too often, only the addresses that it announced last are followed,
  /// and later.
  void follow(RemoteParticipant& remote, LocatorList metatraffic, LocatorList user) {
    if (!remote.has_signed_addresses || metatraffic.empty()) return;
    if (!core_.is_participant_data_proven(remote.prefix())) return;
    remote.next_addresses.reset();
    if (remote.signed_metatraffic == metatraffic && remote.signed_user == user) return;
    if (!remote.moves.try_spend(core_.now)) {
      remote.next_addresses.emplace(std::move(metatraffic), std::move(user));
      return call_at(core_.now + kMovePause);
    }
    adopt_signed_addresses(core_, remote, std::move(metatraffic), std::move(user));
    limit_until_proven(remote);
    readdress(remote);
  }

 private:
  void on_time(MonotonicTime) override {
    for (const auto& [prefix, known] : remotes_.all()) {
      if (!known.next_addresses) continue;
      auto& remote = *remotes_.find(prefix);
      auto [metatraffic, user] = *std::exchange(remote.next_addresses, {});
      follow(remote, std::move(metatraffic), std::move(user));
    }
  }

  ParticipantCore& core_;
  RemoteParticipants& remotes_;
  EndpointMatcher& matcher_;
  BuiltinMatcher& builtin_;
};

}  // namespace ddssec::rtps
