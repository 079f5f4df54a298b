// Shuts out participants that lost their trust: new keys for all others (DDS-Security 1.2
// 9.8.10.4), in use once they have them.
#pragma once

#include "rtps/security/key_exchange.hpp"

namespace ddssec::rtps {

/// One revision at a time. Without `enable_key_revision` in the governance nothing happens.
class KeyRevision {
 public:
  /// Revised keys are in use so long after they were sent at the latest. Receivers let the former
  /// ones count twice as long.
  static constexpr MonotonicTime kPatience = std::chrono::seconds(5);
  /// When making revised keys failed.
  static constexpr MonotonicTime kRetry = std::chrono::seconds(1);
  /// Peers that left with our keys and whose trust is still watched; one more, and keys are
  /// revised.
  static constexpr std::size_t kMaxAbsent = 256;

  KeyRevision(SecurityCore& core, KeyExchange& exchange) : core_(core), exchange_(exchange) {}

  bool is_enabled() const { return core_.own->attributes().is_key_revision_enabled; }
  /// New keys as soon as possible.
  void request() { is_due_ = is_enabled(); }
  void tick();
  MonotonicTime next_tick() const;
  /// Once a second: do the keys' lives end?
  void check_key_life();

  // Peers that left in good standing. What they know of our keys is good as long as their trust.
  /// Takes over the identity and the permissions of a peer that leaves.
  void note_absent(Peer& peer);
  /// nullptr: it did not leave, or is forgotten.
  std::shared_ptr<const PeerIdentity> identity_of_absent(const GuidPrefix& prefix) const;
  /// This participant is not watched from here on, so its keys must not count any longer.
  void drop_absent(const GuidPrefix& prefix);
  /// Requests a revision if `ended(identity, permissions)` for any of them.
  template <class F>
  void check_absent(F&& ended) {
    for (const auto& absent : absent_)
      if (ended(absent.identity->handle(), absent.permissions.handle)) request();
  }

 private:
  struct Absent {
    GuidPrefix prefix;
    PeerPermissions permissions;
    std::shared_ptr<const PeerIdentity> identity;
  };
  /// Revised keys on their way to the peers that are trusted.
  struct UnderWay {
    spi::KeyRevision number;
    MonotonicTime deadline;
  };

  void begin();
  void finish();
  bool all_are_up_to_date() const;

  SecurityCore& core_;
  KeyExchange& exchange_;
  std::vector<Absent> absent_;
  bool is_due_ = false;
  std::optional<UnderWay> under_way_;
  MonotonicTime retry_{};
};

}  // namespace ddssec::rtps
