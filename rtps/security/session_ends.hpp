// Peers that prove that they have ended their session with us (plugins/spi/session_reset.hpp).
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "plugins/spi/session_reset.hpp"

namespace ddssec::rtps {

/// The sessions whose end peers may prove. A session stays until a handshake proves another one: a
/// peer that comes back begins it.
class SessionEnds {
 public:
  /// Notes that a session with the peer begins; a former one no longer counts.
  void expect(const GuidPrefix& peer, const spi::SharedSecret& secret);
  void forget(const GuidPrefix& peer) { sessions_.erase(peer); }
  /// Handles a message in the name of the peer that says that the session has ended. Without a
  /// proof it has no effect.
  void note_reset(const GuidPrefix& peer, const spi::Reset& reset, MonotonicTime now);
  /// Sets what is called when a peer has proven the end of its session.
  void on_proven(std::function<void(const GuidPrefix& peer, MonotonicTime now)> call) {
    on_proven_ = std::move(call);
  }
  /// True if a peer has proven the end of its session since the last call.
  bool take_proven() { return std::exchange(was_proven_, false); }
  /// True if the end of the session with the peer was proven, and no other session began since.
  bool has_ended(const GuidPrefix& peer) const;
  /// True, once for each session, if its end was proven before `time`.
  bool remove_if_before(const GuidPrefix& peer, MonotonicTime time);

 private:
  struct Session {
    spi::ResetToken expected;  ///< the token by which the peer proves the end
    std::optional<MonotonicTime> ended = {};
    bool was_taken = false;
  };
  std::map<GuidPrefix, Session> sessions_;
  std::function<void(const GuidPrefix& peer, MonotonicTime now)> on_proven_;
  bool was_proven_ = false;
};

}  // namespace ddssec::rtps
