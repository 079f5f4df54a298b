// Peers of other products that were not heard for longer than their lease.
#pragma once

#include "rtps/security/key_reviser.hpp"

namespace ddssec::rtps {

/// A peer that does not understand our reset messages may still hear us when its lease ends here.
/// Then it keeps its session, and never authenticates again. So its keys are kept for a while. It
/// is a peer again once it acknowledges a message that was written after the end of its lease.
/// Nothing that was recorded before can do that.
class DormantPeers {
 public:
  /// The limit for all of them. The identity with the most loses its oldest one.
  static constexpr std::size_t kMaxPeers = 64;
  static constexpr MonotonicTime kLife = std::chrono::hours(1);
  /// The shortest time between two queries to one peer, and how long its answer may take.
  static constexpr MonotonicTime kQueryPeriod = std::chrono::seconds(1);
  static constexpr MonotonicTime kAnswerTime = std::chrono::seconds(5);

  DormantPeers(SecurityCore& core, CryptoTokenExchange& exchange, KeyReviser& key_reviser)
      : core_(core), exchange_(exchange), key_reviser_(key_reviser) {}

  /// True if the peer may keep its session without us, and would not begin another one.
  bool can_keep(const GuidPrefix& prefix) const;
  /// Keeps a peer that can_keep() allows, and removes it from the peers.
  void keep(const GuidPrefix& prefix);
  bool contains(const GuidPrefix& prefix) const { return core_.dormant.contains(prefix); }
  /// Notes that something arrived in its name. It is asked whether it is there.
  void note_heard(const GuidPrefix& prefix, MonotonicTime now);
  /// Notes that it acknowledged messages of the key exchange.
  void note_acknowledged(const GuidPrefix& prefix);
  /// Returns the peers that have answered since the last call.
  std::vector<GuidPrefix> take_answered() { return std::exchange(answered_, {}); }
  /// Returns a peer that has answered; empty if it was dropped since.
  std::optional<Peer> take(const GuidPrefix& prefix);

  /// Drops a peer. From now on it is watched like any other peer that left with our keys.
  void drop(const GuidPrefix& prefix);
  /// Drops a peer that is no longer trusted. Keys are revised.
  void distrust(const GuidPrefix& prefix);
  /// Drops those for which `ended(identity, permissions)` is true.
  template <class F>
  void distrust_if(F&& ended) {
    for (const auto& prefix : prefixes()) {
      const auto& association = *core_.dormant.at(prefix).peer.state.association();
      if (ended(association.handshake->identity()->handle(), association.permissions.handle))
        distrust(prefix);
    }
  }
  void drop_all();
  /// Call it once a second.
  void tick();

 private:
  std::vector<GuidPrefix> prefixes() const;
  void make_room();
  /// Sends to the peer at these addresses; with none, nothing is sent to it.
  void send_to(DormantPeer& dormant, const LocatorList& addresses);

  SecurityCore& core_;
  CryptoTokenExchange& exchange_;
  KeyReviser& key_reviser_;
  std::vector<GuidPrefix> answered_;
};

}  // namespace ddssec::rtps
