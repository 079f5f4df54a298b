// The sender's side of one key: its current session, and numbers that are used once.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "base/clock.hpp"
#include "plugins/cryptography/aead.hpp"
#include "plugins/cryptography/derivation.hpp"
#include "plugins/cryptography/fork_generation.hpp"
#include "plugins/cryptography/reclaim.hpp"
#include "plugins/cryptography/send_position.hpp"

namespace ddssec::cryptography {

/// What all keys of one engine share. Outlives them.
struct KeyEnvironment {
  const AeadBackend& aead;
  Graveyard& graveyard;
  std::uint64_t most_blocks_per_session;  ///< at least 1
  std::uint64_t most_sessions_per_key;    ///< at least 1, at most 2^32
  Random& random;
  ForkGeneration& generation = ForkGeneration::of_process();
};

/// Where a sender's numbers start; random.
struct SendStart {
  std::uint32_t session = 0;
  std::uint64_t suffix = 0;

  /// Errors: those of the random source.
  static Result<SendStart> draw(Random& random);
};

/// One expanded session key with its counter. Immutable but for the counter.
struct SendSession final : Retirable {
  SessionId id;
  std::uint64_t number = 0;      ///< 0 for the first of its key
  std::uint64_t suffix = 0;      ///< of the first IV
  std::uint64_t generation = 0;  ///< of the process that may use it
  SessionRange begun;            ///< by this process with this key, up to this session
  std::vector<SessionRange> begun_by_parents;  ///< one for each fork() since the key was made
  ExpandedKey key;
  /// AES blocks promised so far. On a cache line of its own: all threads that send write it.
  alignas(64) std::atomic<std::uint64_t> used = 0;
};

/// Encrypts or signs for one local entity at one level. Any number of threads.
///
/// No IV comes twice under one session key: a message of n blocks reserves n numbers of the session
/// by one atomic addition, and its suffix is the start plus the first of them. Two messages reserve
/// different numbers, and no more than most_blocks_per_session (plus one addition a thread, unused)
/// are ever given out, far below the 2^64 after which suffixes would come again. No session id
/// comes twice under one master key: ids count up and stop after most_sessions_per_key.
///
/// The first session is expanded for the first message: a reader has a key for each participant
/// that writes its topic, and a best-effort one never uses them.
///
/// A child of fork() has the key and the numbers of its parent, which goes on to use them. Before
/// its first message it leaves its parent's session for one whose id and suffix are random: the
/// two would have to agree in 32 bits and to within 2^32 in 64 more.
class SendKey final : public Retirable {
 public:
  /// Errors: internal (no kind of a key).
  static Result<std::unique_ptr<SendKey>> create(KeyMaterial material, SendStart start,
                                                 const KeyEnvironment& environment);

  const KeyMaterial& material() const { return material_; }
  const KindTraits& traits() const { return traits_; }

  struct Reservation {
    const SendSession* session;  ///< valid as long as the ReadGuard
    Iv iv;
  };
  /// Under a ReadGuard: an IV for a message of `size` octets and its receiver-specific MACs.
  /// Errors: session_ids_exhausted, internal; in a child of fork() those of the random source.
  Result<Reservation> reserve(std::size_t size);
  /// Under a ReadGuard: is this session one of those used so far, by this process or a parent
  /// before its fork()? They start at random, so that one of another sender with the same master
  /// key is not, but for one chance in 2^32.
  bool has_begun(SessionId session) const;
  /// Under a ReadGuard: where the next message will stand. Those that other threads protect
  /// meanwhile may count as passed.
  SendPosition position() const;
  /// Under a ReadGuard: AES blocks promised so far, and what finished sessions left over.
  std::uint64_t blocks_used() const;

 private:
  SendKey(KeyMaterial material, KindTraits traits, SendStart start,
          const KeyEnvironment& environment)
      : material_(std::move(material)),
        traits_(traits),
        environment_(environment),
        start_(start),
        generation_(environment.generation.current()) {}
  Result<std::unique_ptr<SendSession>> first_session() const;
  Result<std::unique_ptr<SendSession>> session_after(const SendSession& former) const;
  Status expand(SendSession& session) const;
  /// Goes on to the next session, or the first after none, unless another thread did.
  Status roll_over(const SendSession* former);

  const KeyMaterial material_;
  const KindTraits traits_;
  const KeyEnvironment& environment_;
  const SendStart start_;
  const std::uint64_t generation_;  // of the process that drew it
  Published<SendSession> current_;  // null before the first message
  std::mutex mutex_;                // held by who rolls over
};

/// The receiver-specific key that a local sender has for one remote receiver
/// (DDS-Security 9.5.3.3.3), expanded for the sender's current session.
class ReceiverKey final : public Retirable {
 public:
  ReceiverKey(KeyId id, MasterReceiverKey key, const KeyEnvironment& environment)
      : id_(id), key_(std::move(key)), environment_(environment) {}

  KeyId id() const { return id_; }
  const MasterReceiverKey& master() const { return key_; }

  /// Under a ReadGuard: the GMAC of `common_mac` for this receiver. `sender` and `reservation`
  /// belong together. Errors: internal.
  Status mac(const SendKey& sender, const SendKey::Reservation& reservation, TagView common_mac,
             TagOut out);

 private:
  /// The salt is the sender's: another revision's session of the same number is another one.
  struct Session final : Retirable {
    SessionId id;
    TransformKind kind;
    ExpandedKey key;
    bool is_of(const SendKey& sender, SessionId session) const {
      return id == session && kind == sender.material().kind;
    }
  };
  Result<const Session*> expand(const SendKey& sender, SessionId id);

  const KeyId id_;
  const MasterReceiverKey key_;
  const KeyEnvironment& environment_;
  Published<Session> current_;
  std::mutex mutex_;  // held by who expands
};

}  // namespace ddssec::cryptography
