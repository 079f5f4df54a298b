// Sessions with peers that the host has dropped while the peer may have kept them: after a link
// that failed in one direction only, for example. Such a peer gets our reset token
// (plugins/spi/session_reset.hpp), or it would ignore every new handshake: often when it is met
// again, and seldom while it is not, since a forged announcement can keep our host from meeting it.
// A participant of ours that ends sends them its tokens, too: the clear farewell of its host is not
// believed, and its secured one finds no peer any more.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"
#include "plugins/spi/session_reset.hpp"
#include "plugins/spi/udp_address.hpp"

namespace ddssec::cyclonedds {

/// Thread-safe.
class LostSessions {
 public:
  using Duration = std::chrono::nanoseconds;
  /// Between two resets of one session: at first, and after kSoon of them, when the peer is out of
  /// reach, or has another vendor's plugins.
  static constexpr Duration kInterval = std::chrono::seconds(3);
  static constexpr Duration kLongInterval = std::chrono::seconds(30);
  static constexpr unsigned kSoon = 10;
  /// How long after a loss the first of them goes to a peer that is not met again, and the second;
  /// each further one after twice the time. Between the first two there is time for the peer to
  /// notice that we do not answer (HandshakeWatch::kLongPatience): the farewell beside a reset
  /// makes it begin anew.
  static constexpr Duration kFirstUnmet = std::chrono::seconds(4);
  static constexpr Duration kSecondUnmet = std::chrono::seconds(32);
  /// Most resets for such peers at once. The others are due the next time.
  static constexpr unsigned kMostUnmet = 32;
  /// How long a lost session is remembered. A peer that was out of reach for longer and kept the
  /// session has a lease that long.
  static constexpr Duration kMemory = std::chrono::minutes(30);
  /// Most lost sessions remembered of each local participant, and most of them with participants of
  /// one certificate: as many as it may have. Beyond its share the certificate's session that was
  /// lost first gives way; beyond kMostLost that of the certificate with the most.
  static constexpr std::size_t kMostLost = 4096;
  static constexpr std::size_t kMostOfSubject = 625;
  /// Most addresses of one peer that are used.
  static constexpr std::size_t kMostAddresses = 4;

  explicit LostSessions(const Clock& clock) : clock_(clock) {}

  void add_local(spi::IdentityHandle local, const GuidPrefix& prefix);
  struct Reset {
    Bytes message;
    std::vector<spi::UdpAddress> to;
  };
  /// A local participant is gone, with its sessions. What tells its peers so.
  std::vector<Reset> remove_local(spi::IdentityHandle local);
  /// Two participants have authenticated: forgets a session that they had lost before.
  void established(spi::IdentityHandle local, const Guid& remote, const spi::SharedSecret& secret);
  /// The host has dropped the remote participant.
  void lost(const Guid& remote);

  /// Where a peer of a session could be reached; none without one.
  std::vector<spi::UdpAddress> addresses_of(const Guid& remote);

  struct Due {
    spi::IdentityHandle local;
    GuidPrefix own;
    Guid remote;
    bool is_meeting;  ///< the host meets them again
    Bytes message;
    std::vector<spi::UdpAddress> to;
  };
  /// Is the host meeting this pair again?
  using IsMeeting = std::function<bool(spi::IdentityHandle local, const Guid& remote)>;
  /// What is to be sent now.
  std::vector<Due> due(const IsMeeting& is_meeting);

 private:
  struct Session {
    GuidPrefix sender;
    spi::ResetToken token;
    std::vector<spi::UdpAddress> to;
    std::uint64_t lost = 0;  ///< the number of its loss; 0: not lost
    Duration lost_at{};
    Duration next{};
    unsigned sent = 0;
    unsigned sent_unmet = 0;
  };
  using Key = std::pair<Guid, spi::IdentityHandle>;  ///< remote, local
  /// The first half of a prefix, which the remote proved to be bound to its certificate's subject
  /// (DDS-Security 9.3.3).
  using Subject = std::array<std::uint8_t, 6>;
  using InOrder = std::set<std::pair<std::uint64_t, Key>>;  ///< by the number of their loss
  struct Local {
    GuidPrefix prefix;
    std::map<Subject, InOrder> lost = {};
    std::size_t all_lost = 0;
  };
  using Sessions = std::map<Key, Session>;

  static Subject subject_of(const Key& key);
  static Duration unmet_wait(unsigned sent);
  static bool is_due(const Session& session, bool is_meeting, Duration now);
  static void note_sent(Session& session, bool is_meeting, Duration now);
  void note_lost(const Key& key, Session& session);
  void no_longer_lost(const Key& key, Session& session);
  void forget_first(const InOrder& in_order);
  void forget_lost_before(Duration time);

  const Clock& clock_;
  std::mutex mutex_;
  std::map<spi::IdentityHandle, Local> locals_;
  Sessions sessions_;
  std::uint64_t losses_ = 0;
};

}  // namespace ddssec::cyclonedds
