// Peers that prove that they have ended their session with us (plugins/spi/session_reset.hpp).
#pragma once

#include <map>
#include <optional>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "plugins/spi/session_reset.hpp"

namespace ddssec::rtps {

/// The sessions stay until a handshake proves other ones: a peer that comes back begins it.
class SessionEnds {
 public:
  /// A session with the peer begins; a former one no longer counts.
  void expect(const GuidPrefix& peer, const spi::SharedSecret& secret);
  void forget(const GuidPrefix& peer) { sessions_.erase(peer); }
  /// A message in the name of the peer says that the session has ended. Without a proof it has no
  /// effect.
  void received(const GuidPrefix& peer, const spi::Reset& reset, MonotonicTime now);
  /// True, once for each session, if its end was proven before `time`.
  bool take_before(const GuidPrefix& peer, MonotonicTime time);

 private:
  struct Session {
    spi::ResetToken expected;  ///< by which the peer proves the end
    std::optional<MonotonicTime> ended = {};
    bool was_taken = false;
  };
  std::map<GuidPrefix, Session> sessions_;
};

}  // namespace ddssec::rtps
