// Excludes participants that lost their trust: creates new keys for all others (DDS-Security 1.2,
// clause 9.8.10.4), and uses them once the others have them.
#pragma once

#include "rtps/security/crypto_token_exchange.hpp"

namespace ddssec::rtps {

/// Revises keys, one revision at a time. Does nothing without `enable_key_revision` in the
/// governance.
class KeyReviser {
 public:
  /// The longest time between sending revised keys and using them. Receivers accept the former keys
  /// for twice as long.
  static constexpr MonotonicTime kTimeout = std::chrono::seconds(5);
  /// Time until the next attempt after creating revised keys failed.
  static constexpr MonotonicTime kRetry = std::chrono::seconds(1);
  /// The longest time for which a revision that can wait does so while the governance changes.
  static constexpr MonotonicTime kMaxDelay = std::chrono::seconds(60);
  /// The shortest time between the beginnings of a revision and of one that can wait. Within it the
  /// former keys end everywhere, so that receivers recover from what was forged with them.
  static constexpr MonotonicTime kMinInterval =
      kTimeout + spi::kFormerKeyLife + std::chrono::seconds(2);
  /// Limit for peers that left with the local keys and whose trust is still watched. If there is
  /// one more, keys are revised, as for right_lost: it was trusted when it left.
  static constexpr std::size_t kMaxAbsent = 256;

  KeyReviser(SecurityCore& core, CryptoTokenExchange& exchange)
      : core_(core), exchange_(exchange) {}

  bool is_enabled() const { return core_.own->attributes().is_key_revision_enabled; }
  /// True if a revision is under way, or requested and does not wait.
  bool is_busy() const { return under_way_ || is_urgent(); }
  enum class RevisionReason : std::uint8_t {
    trust_lost,  ///< trust was lost, or the application asked for it: as soon as possible
    /// A peer may do less than before: when the governance does not change, and kMinInterval after
    /// the last revision.
    right_lost,
  };
  void request(RevisionReason reason = RevisionReason::trust_lost);
  void tick();
  MonotonicTime next_tick() const;
  /// Call it once a second: checks whether the lifetime of the keys has ended.
  void poll_key_life();

  // Functions for peers that left while they were trusted. Their knowledge of the local keys is
  // acceptable as long as they are trusted.
  /// Takes over the identity and the permissions of a peer that leaves.
  void note_absent(Peer& peer);
  /// Returns the identity of a peer that left, or is dormant; nullptr if it did not leave, or is
  /// forgotten.
  std::shared_ptr<const PeerIdentity> identity_of_absent(const GuidPrefix& prefix) const;
  /// Stops watching the participant. If it was watched, requests a revision that makes its keys
  /// useless. Pass right_lost if it has returned: it is watched like any other peer again, and the
  /// revision may wait.
  void drop_absent(const GuidPrefix& prefix, RevisionReason reason);
  /// Requests a revision if `ended(identity, permissions)` is true for any of them.
  template <class F>
  void poll_absent(F&& ended) {
    for (const auto& absent : absent_)
      if (ended(absent.identity->handle(), absent.permissions.handle)) request();
  }

 private:
  struct AbsentPeer {
    GuidPrefix prefix;
    PeerPermissions permissions;
    std::shared_ptr<const PeerIdentity> identity;
  };
  /// Revised keys that are being sent to the trusted peers.
  struct PendingRevision {
    spi::KeyRevision number;
    MonotonicTime deadline;
  };

  /// Returns the time at which the requested revision may begin.
  MonotonicTime beginning() const;
  bool is_urgent() const { return due_by_ && core_.now >= *due_by_; }
  void begin();
  void finish();
  bool all_are_up_to_date() const;

  SecurityCore& core_;
  CryptoTokenExchange& exchange_;
  std::vector<AbsentPeer> absent_;
  std::optional<MonotonicTime> due_by_;  ///< a revision is requested, and must begin by then
  std::optional<PendingRevision> under_way_;
  MonotonicTime retry_{};
  MonotonicTime next_that_can_wait_{};
};

}  // namespace ddssec::rtps
