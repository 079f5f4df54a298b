// Sessions with peers that the host has dropped while the peer may have kept them: after a link
// that failed in one direction only, for example. When such a peer is met again, it gets our reset
// token (plugins/spi/session_reset.hpp), or it would ignore every new handshake.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <span>
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
  /// How long a lost session is remembered. A peer that was out of reach for longer and kept the
  /// session has a lease that long.
  static constexpr Duration kMemory = std::chrono::minutes(30);
  /// Most lost sessions remembered; the one lost first gives way.
  static constexpr std::size_t kMostLost = 4096;
  /// Most addresses of one peer that are used.
  static constexpr std::size_t kMostAddresses = 4;

  explicit LostSessions(const Clock& clock) : clock_(clock) {}

  void add_local(spi::IdentityHandle local, const GuidPrefix& prefix);
  /// A local participant is gone, with its sessions.
  void remove_local(spi::IdentityHandle local);
  /// Two participants have authenticated: forgets a session that they had lost before.
  void established(spi::IdentityHandle local, const Guid& remote, const spi::SharedSecret& secret);
  /// The host has dropped the remote participant.
  void lost(const Guid& remote);

  /// Where a peer of a session could be reached; none without one.
  std::vector<spi::UdpAddress> addresses_of(const Guid& remote);

  struct Due {
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
    bool is_lost = false;
    Duration lost_at{};
    Duration next{};
    unsigned sent = 0;
  };
  using Key = std::pair<Guid, spi::IdentityHandle>;  ///< remote, local

  void forget_lost_before(Duration time);
  void make_room();

  const Clock& clock_;
  std::mutex mutex_;
  std::map<spi::IdentityHandle, GuidPrefix> locals_;
  std::map<Key, Session> sessions_;
  std::size_t lost_ = 0;
};

}  // namespace ddssec::cyclonedds
