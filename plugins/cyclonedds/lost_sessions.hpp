// Sessions with peers that the host has dropped although the peer may have kept them, for example
// after a link that failed in one direction only. Such a peer is sent the reset token
// (plugins/spi/session_reset.hpp), because otherwise it ignores every new handshake. The token is
// sent often while the host discovers the peer again. It is sent seldom while the host does not,
// because a forged announcement can keep the host from discovering it.
//
// A local participant that ends also sends its tokens to its peers. They do not trust the
// unprotected dispose announcement of its host, and the protected one no longer reaches any peer.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include "base/clock.hpp"
#include "base/hash.hpp"
#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/session_reset.hpp"
#include "plugins/spi/udp_address.hpp"

namespace ddssec::cyclonedds {

/// The sessions, lost or not. Thread-safe.
class LostSessions {
 public:
  using Duration = std::chrono::nanoseconds;
  /// The time between two resets of one session: first the short interval, and after kSoon resets
  /// the long one. The peer is then out of reach, or has another vendor's plugins.
  static constexpr Duration kInterval = std::chrono::seconds(3);
  static constexpr Duration kLongInterval = std::chrono::seconds(30);
  static constexpr unsigned kSoon = 10;
  /// The time from a loss to the first and to the second reset for a peer that the host does not
  /// discover again. Each further one is sent after twice the time. The time between the first two
  /// is long enough for the peer to notice that the local side does not answer
  /// (HandshakeWatch::kTimeout): the dispose announcement that is sent with a reset makes the peer
  /// restart its handshake.
  static constexpr Duration kFirstUndiscovered = std::chrono::seconds(4);
  static constexpr Duration kSecondUndiscovered = std::chrono::seconds(32);
  /// The time from a loss to the first reset for a peer that is cut off.
  static constexpr Duration kFirstOfCutOff = std::chrono::seconds(2);
  /// The largest number of resets for such peers at once. The others are due the next time.
  static constexpr unsigned kMaxUndiscovered = 32;
  /// How long a lost session is remembered after the host has last discovered the peer. While it is
  /// discovered, it may still have the session: an attacker can keep every reset from it.
  static constexpr Duration kMemory = std::chrono::hours(24);
  /// The largest number of lost sessions for each local participant, and of those with participants
  /// of one certificate: as many as it may have. Beyond the share of a certificate, its oldest lost
  /// session is dropped. Beyond kMaxLost, that of the certificate with the most lost sessions is
  /// dropped.
  static constexpr std::size_t kMaxLost = 4096;
  static constexpr std::size_t kMaxOfSubject = 625;
  /// The largest number of addresses used for one peer.
  static constexpr std::size_t kMaxAddresses = 4;

  explicit LostSessions(const Clock& clock) : clock_(clock) {}

  void add_local(spi::IdentityHandle local, const GuidPrefix& prefix);
  struct Reset {
    Bytes message;
    std::vector<spi::UdpAddress> to;
  };
  /// Removes a local participant that has ended, with its sessions. Returns the resets that inform
  /// its peers.
  std::vector<Reset> remove_local(spi::IdentityHandle local);
  /// The SHA-256 of the permissions that a handshake presented (spi::SessionFacts).
  using Presented = std::optional<Sha256Digest>;
  /// Notes that two participants have authenticated. A session that they had lost before is
  /// forgotten.
  void established(spi::IdentityHandle local, const Guid& remote, const spi::SharedSecret& secret,
                   const Presented& presented = {});
  /// Notes that the host has dropped the remote participant.
  void lost(const Guid& remote);
  /// Notes that the host is about to drop it for all local participants, because one of its
  /// sessions was reset. The others are reset at once. If a new session began first, the reset
  /// would end it too, and both processes could reset each other forever.
  void about_to_drop(const Guid& remote);
  /// Notes the same for a participant whose certificate has ended or no longer counts. It is reset
  /// soon, so that it is informed. But a participant whose certificate has ended must have noticed
  /// that first: to follow the reset, its process would interrupt the sessions of its other
  /// participants.
  void about_to_cut_off(const Guid& remote);

  struct Begun {
    Duration at{};
    Presented presented = {};  ///< by the local side
  };
  /// Returns how the session of the two began; empty if they have none, or if it was lost.
  std::optional<Begun> session(spi::IdentityHandle local, const Guid& remote) const;
  /// True if the two have a session that was not lost.
  bool has_session(spi::IdentityHandle local, const Guid& remote) const {
    return session(local, remote).has_value();
  }

  /// Returns the addresses of a peer; empty if there is no session with it.
  std::vector<spi::UdpAddress> addresses_of(const Guid& remote);

  struct DueReset {
    spi::IdentityHandle local;
    GuidPrefix own;
    Guid remote;
    bool discovers;  ///< true if the host discovers the peer again
    Bytes message;
    std::vector<spi::UdpAddress> to;
  };
  /// Returns whether the host is discovering this pair again.
  using Discovers = std::function<bool(spi::IdentityHandle local, const Guid& remote)>;
  /// Returns the resets to send now.
  std::vector<DueReset> due(const Discovers& discovers);

 private:
  struct Session {
    GuidPrefix sender;
    spi::ResetToken token;
    std::vector<spi::UdpAddress> to;
    Begun begun;
    std::uint64_t lost = 0;  ///< sequence number of its loss; 0 if it is not lost
    Duration lost_at{};
    Duration discovered_at{};  ///< when the host last discovered the peer, or lost the session
    Duration next{};
    unsigned sent = 0;
    unsigned sent_undiscovered = 0;
    /// The time until the first reset for a peer that is not discovered.
    Duration first_undiscovered = kFirstUndiscovered;
  };
  using Key = std::pair<Guid, spi::IdentityHandle>;  ///< remote, local
  /// The first half of a proven prefix, which is bound to the subject of the remote participant's
  /// certificate (DDS-Security 1.2, clause 10.3.3).
  using Subject = std::array<std::uint8_t, 6>;
  /// Sessions by the sequence number of their loss.
  using InOrder = std::set<std::pair<std::uint64_t, Key>>;
  struct Local {
    GuidPrefix prefix;
    std::map<Subject, InOrder> lost = {};
    std::size_t all_lost = 0;
  };
  using Sessions = std::map<Key, Session>;

  static Subject subject_of(const Key& key);
  void reset_after(const Guid& remote, Duration wait);
  static Duration wait_while_undiscovered(const Session& session);
  static bool is_due(const Session& session, bool discovers, Duration now);
  static void note_sent(Session& session, bool discovers, Duration now);
  void note_lost(const Key& key, Session& session);
  void forget_loss(const Key& key, Session& session);
  void forget_first(const InOrder& in_order);

  const Clock& clock_;
  mutable std::mutex mutex_;
  std::map<spi::IdentityHandle, Local> locals_;
  Sessions sessions_;
  std::uint64_t losses_ = 0;
};

}  // namespace ddssec::cyclonedds
