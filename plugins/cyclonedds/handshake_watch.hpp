// Handshakes that come to no end. Cyclone's core runs one for each remote participant that it
// discovers, and a message that a stranger forges in the peer's name can leave it in a state from
// which it never starts again while the peer is there. Then the peer is revoked: the core forgets
// it, discovers it anew and begins again.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// By the host's handles of remote identities, which all its participants share. Thread-safe.
class HandshakeWatch {
 public:
  using Duration = std::chrono::nanoseconds;
  /// How long a handshake may stand still, once a request was refused and before we sent anything.
  static constexpr Duration kPatience = std::chrono::milliseconds(2500);
  /// How long in every other case. Long, because a busy peer may only be slow, and one that has
  /// answered us, or finished its half, does not notice that we begin again.
  static constexpr Duration kLongPatience = std::chrono::seconds(20);
  /// Each further time the wait doubles, up to this. No handshake lives longer: after 100 seconds
  /// the core's own timer ends it, and Cyclone DDS 0.10.2 then damages its list of timers.
  static constexpr Duration kMaxWait = std::chrono::seconds(80);
  /// The same where governance lets unauthenticated participants in: the core takes the peer for
  /// one when its timer ends the handshake.
  static constexpr Duration kMaxWaitForUnauthenticated = std::chrono::seconds(120);
  /// A peer that was not given up for so long starts from the beginning.
  static constexpr Duration kForgetAfter = std::chrono::minutes(10);
  static constexpr std::size_t kMaxPeers = 1024;

  explicit HandshakeWatch(const Clock& clock) : clock_(clock) {}

  void met(spi::IdentityHandle remote, const Guid& guid, Duration longest_wait = kMaxWait);
  /// What was announced in its name was refused; the host asks again, and its wait goes on.
  void not_admitted(spi::IdentityHandle remote, const Guid& guid);
  /// We sent a request or a reply.
  void progressed(spi::IdentityHandle remote, spi::HandshakeHandle handshake);
  /// A request, or a message of this handshake, was refused.
  void refused(spi::IdentityHandle remote);
  void refused(spi::HandshakeHandle handshake);
  /// From now on the remote is not given up, whatever becomes of other handshakes with it; unless
  /// its keys do not come, which says that it did not finish its half.
  void finished(spi::HandshakeHandle handshake);
  /// The peer has finished its half, and would not notice that we begin again: its keys are waited
  /// for as long as there can be a handshake, unless a message was refused.
  void keeps_its_session(spi::HandshakeHandle handshake);
  void forget(spi::HandshakeHandle handshake);
  void forget(spi::IdentityHandle remote);

  struct Stuck {
    spi::IdentityHandle remote;
    Guid guid;
    bool was_disturbed;    ///< a message was refused
    bool lacks_endpoints;  ///< all else is done
    bool is_first;         ///< of this GUID, as far as is remembered
    Duration waited;
  };
  /// What our cryptography knows of a remote. Without a function no answer is waited for.
  struct Questions {
    /// Has the remote sent its keys?
    std::function<bool(spi::IdentityHandle)> has_keys = {};
    /// Has the host matched it with all our builtin endpoints? A forged announcement, in which some
    /// are missing or which disposes one, would keep the two from discovering each other's
    /// endpoints: builtin endpoints go with their participant only.
    std::function<bool(spi::IdentityHandle)> is_matched = {};
    /// When did the remote last show that it has our shared secret? It finished its half then, and
    /// its keys may still come: a peer that does not notice that we begin anew is not given up.
    std::function<Duration(spi::IdentityHandle)> last_heard = {};
  };
  /// Those to be revoked now, each once.
  std::vector<Stuck> give_up(const Questions& ask);
  std::vector<Stuck> give_up() { return give_up({}); }

 private:
  struct Remote {
    Guid guid;
    Duration met;
    Duration since = met;  ///< its last progress
    Duration longest_wait = kMaxWait;
    bool keeps_its_session = false;
    bool was_disturbed = false;
    bool is_under_way = false;  ///< we sent a request or a reply
    bool is_finished = false;
    bool lacks_endpoints = false;
    bool is_settled = false;  ///< not to be given up while its builtin endpoints are there
  };
  struct Past {
    unsigned times = 0;
    Duration last{};
  };
  Duration patience(const Remote& remote) const;
  bool is_settled(spi::IdentityHandle handle, Remote& remote, const Questions& ask) const;
  void await_keys(spi::IdentityHandle handle, Remote& remote, const Questions& ask) const;
  bool is_stuck(const Remote& remote, Duration now) const;
  Past& past_of(const Guid& guid, Duration now);
  Remote* of(spi::HandshakeHandle handshake);

  const Clock& clock_;
  std::mutex mutex_;
  std::map<spi::IdentityHandle, Remote> remotes_;
  std::map<spi::HandshakeHandle, spi::IdentityHandle> handshakes_;
  std::map<Guid, Past> past_;
};

}  // namespace ddssec::cyclonedds
