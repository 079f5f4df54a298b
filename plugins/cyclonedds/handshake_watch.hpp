// Watches for handshakes that do not end. Cyclone's core runs one for each remote participant that
// it discovers. A message that an attacker forges in the peer's name can leave it in a state from
// which it never starts again while the peer is present. Then the peer is revoked: the core forgets
// it, discovers it again and restarts the handshake.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <vector>

#include "base/clock.hpp"
#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// The watched remote participants, by the host's handles, which all local participants share.
/// Thread-safe.
class HandshakeWatch {
 public:
  using Duration = std::chrono::nanoseconds;
  /// The longest time without progress after a request was refused and before anything was sent.
  static constexpr Duration kTimeoutAfterRefusal = std::chrono::milliseconds(2500);
  /// The longest time without progress in every other case. It is long, because a busy peer may
  /// only be slow. A peer that has answered, or has finished its half, does not notice that the
  /// local side begins again.
  static constexpr Duration kTimeout = std::chrono::seconds(20);
  /// The wait doubles each further time, up to this value. It is shorter than that of the core's
  /// own timer (CoreTimer).
  static constexpr Duration kMaxWait = std::chrono::seconds(80);
  /// A peer that was not given up for this long starts with the shortest wait again.
  static constexpr Duration kForgetAfter = std::chrono::minutes(10);
  static constexpr std::size_t kMaxPeers = 1024;
  /// The time between unused resets that are followed. A peer that refuses the permissions of one
  /// local participant loses that session each time, and asks for as long as it is there
  /// (LostSessions::kMemory).
  static constexpr Duration kUnusedResets = std::chrono::minutes(20);

  explicit HandshakeWatch(const Clock& clock) : clock_(clock) {}

  /// A local participant and a remote one.
  struct WatchedPair {
    spi::IdentityHandle local;
    spi::IdentityHandle remote;
  };
  /// Tells whether the core's own timer still runs for the handshake.
  enum class CoreTimerState { stopped, runs };
  /// Notes that the host has discovered a remote participant.
  void note_discovered(WatchedPair pair, const Guid& guid,
                       CoreTimerState timer = CoreTimerState::stopped);
  /// Notes that an announcement in its name was refused. The host asks again, and the wait
  /// continues.
  void note_not_admitted(WatchedPair pair, const Guid& guid,
                         CoreTimerState timer = CoreTimerState::stopped);
  /// True if the peer was given up after kMaxWait, and is not forgotten yet. If governance admits
  /// unauthenticated participants, it counts as one of them afterwards.
  bool was_unanswered(const Guid& remote) const;
  /// Notes that a request or a reply was sent.
  void note_progress(WatchedPair pair, spi::HandshakeHandle handshake);
  /// Notes that a request, or a message of this handshake, was refused.
  void note_refused(spi::IdentityHandle remote);
  void note_refused(spi::HandshakeHandle handshake);
  /// Notes that the handshake has ended. From now on the remote participant is given up in two
  /// cases only:
  /// - Its keys do not come, so it did not finish its half.
  /// - Another local participant gets no session with it. This is done once, because it ends the
  ///   present session. It is not done if the peer would keep that session; then the handshake
  ///   waits until the peer answers.
  void note_finished(spi::HandshakeHandle handshake);
  /// Notes that the peer has finished its half, and would not notice that the local side begins
  /// again. Its keys are awaited as long as a handshake can last, unless a message was refused.
  void note_session_kept(spi::HandshakeHandle handshake);
  /// Notes that the peer proved that it lost a session that was never used (SessionReset). The host
  /// can only end all its sessions. Returns true if it is to do so, at most once in kUnusedResets.
  bool follows_unused_reset(const Guid& remote);
  void forget(spi::HandshakeHandle handshake);
  /// Forgets a local or a remote participant.
  void forget(spi::IdentityHandle participant);

  struct StuckHandshake {
    spi::IdentityHandle remote;
    Guid guid;
    bool was_disturbed;    ///< true if a message was refused
    bool lacks_endpoints;  ///< true if everything else is done
    bool is_first;         ///< true for the first time for this GUID, as far as remembered
    Duration waited;
    /// True if another local participant has a session with it.
    bool is_shared = false;
    bool is_once = false;  ///< true if it is not done again
  };
  /// Questions to libddssec_cryptography about a remote participant. An empty function is not
  /// asked.
  struct Questions {
    /// True if the remote participant has sent its keys.
    std::function<bool(spi::IdentityHandle)> has_keys = {};
    /// True if it has sent keys for that local participant, the second one.
    std::function<bool(spi::IdentityHandle, spi::IdentityHandle)> has_keys_for = {};
    /// True if the host has matched it with all local builtin endpoints. A forged announcement that
    /// omits or disposes some of them would keep the two participants from discovering each other's
    /// endpoints, because the host removes builtin endpoints only together with their participant.
    std::function<bool(spi::IdentityHandle)> is_matched = {};
    /// The time when the remote participant last showed that it has the shared secret. It had
    /// finished its half then, and its keys may still come. A peer that does not notice that the
    /// local side restarts is not given up.
    std::function<Duration(spi::IdentityHandle)> last_heard = {};
  };
  /// Returns the remote participants to revoke now, each once.
  std::vector<StuckHandshake> give_up(const Questions& ask);
  std::vector<StuckHandshake> give_up() { return give_up({}); }

 private:
  /// The handshake of one local participant with a remote one.
  struct LocalHandshake {
    Duration discovered;
    CoreTimerState timer;
    /// The time when the host asked again about a peer that is not admitted.
    std::optional<Duration> asked_again = {};
    bool is_finished = false;
  };
  struct Remote {
    Guid guid;
    Duration discovered;
    Duration since = discovered;  ///< time of the last progress
    bool keeps_session = false;
    bool was_disturbed = false;
    bool is_under_way = false;  ///< true if a request or a reply was sent
    bool is_finished = false;
    bool lacks_endpoints = false;
    /// True if it is not given up while its builtin endpoints are matched.
    bool is_settled = false;
    /// The handshakes by local participant, until its keys are there.
    std::map<spi::IdentityHandle, LocalHandshake> unfinished = {};
  };
  struct PastWaits {
    unsigned times = 0;
    Duration last{};
    bool was_longest = false;  ///< true if the wait was as long as possible
  };
  Duration timeout(const Remote& remote) const;
  bool is_settled(spi::IdentityHandle handle, Remote& remote, const Questions& ask) const;
  void await_keys(spi::IdentityHandle handle, Remote& remote, const Questions& ask) const;
  bool is_stuck(const Remote& remote, Duration now) const;
  void note_finished(spi::IdentityHandle handle, Remote& remote, const Questions& ask);
  void note_begun_again(const Guid& remote, Duration now);
  bool begin_pair_again(const LocalHandshake& half, const Remote& remote);
  bool give_up_pairs(spi::IdentityHandle handle, const Remote& remote,
                     std::vector<StuckHandshake>& out);
  PastWaits& past_of(const Guid& guid, Duration now);
  Remote* of(spi::HandshakeHandle handshake);

  const Clock& clock_;
  mutable std::mutex mutex_;
  std::map<spi::IdentityHandle, Remote> remotes_;
  std::map<spi::HandshakeHandle, WatchedPair> handshakes_;
  std::map<Guid, PastWaits> past_;
  /// The times when remote participants were last revoked for one local participant while another
  /// had a session with them. They are kept until all have one.
  std::map<Guid, Duration> begun_again_;
};

}  // namespace ddssec::cyclonedds
