// The sending side of one key: its current session, and numbers that are used only once.
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

/// The services that all keys of one plugin share. It must outlive them.
struct KeyServices {
  const AeadBackend& aead;
  RetiredObjects& retired_objects;
  std::uint64_t max_blocks_per_session;  ///< at least 1
  std::uint64_t max_sessions_per_key;    ///< at least 1, at most 2^32
  Random& random;
  ForkGeneration& generation = ForkGeneration::of_process();
};

/// The random start of a sender's numbers.
struct SendStart {
  std::uint32_t session = 0;
  std::uint64_t suffix = 0;

  /// Draws a start. Errors: those of the random source.
  static Result<SendStart> draw(Random& random);
};

/// One expanded session key with its counter. Only the counter changes.
struct SendSession final : RetirableObject {
  SessionId id;
  std::uint64_t number = 0;      ///< 0 for the first of its key
  std::uint64_t suffix = 0;      ///< the suffix of the first IV
  std::uint64_t generation = 0;  ///< the generation of the process that may use the session
  SessionRange begun;            ///< sessions of this process with this key, up to this one
  std::vector<SessionRange> begun_by_parents;  ///< one for each fork() since the key was made
  ExpandedKey key;
  /// AES blocks reserved so far. It has its own cache line, because all sending threads write to
  /// it.
  alignas(64) std::atomic<std::uint64_t> used = 0;
};

/// Encrypts or signs for one local entity at one level. Any number of threads may use it.
///
/// No IV is used twice under one session key. A message of n blocks reserves n numbers of the
/// session by one atomic addition; its suffix is the start plus the first of them. Two messages
/// never reserve the same number. At most max_blocks_per_session numbers are ever given out (plus
/// one unused addition per thread), far below the 2^64 after which suffixes would repeat. No
/// session id is used twice under one master key: ids count up and stop after
/// max_sessions_per_key.
///
/// The first session is expanded only for the first message, because a reader has a key for each
/// participant that writes its topic, and a best-effort reader never uses these keys.
///
/// A child of fork() has the key and the numbers of its parent, which continues to use them. Before
/// its first message the child leaves its parent's session for one with a random id and suffix. A
/// collision would need the two to agree in 32 bits, and to within 2^32 in 64 more.
class SendKey final : public RetirableObject {
 public:
  /// Creates the key. Error: internal (the kind is not that of a key).
  static Result<std::unique_ptr<SendKey>> create(KeyMaterial material, SendStart start,
                                                 const KeyServices& services);

  const KeyMaterial& material() const { return material_; }
  const KindTraits& traits() const { return traits_; }

  struct Reservation {
    const SendSession* session;  ///< valid as long as the ReadGuard
    Iv iv;
  };
  /// Reserves an IV for a message of `size` octets and its receiver-specific MACs. Under a
  /// ReadGuard. Errors: session_ids_exhausted, internal; in a child of fork() those of the random
  /// source.
  Result<Reservation> reserve(std::size_t size);
  /// True if the session was used so far, by this process or by a parent before its fork().
  /// Sessions start at random, so a session of another sender with the same master key gives true
  /// with a probability of 2^-32 only. Under a ReadGuard.
  bool has_begun(SessionId session) const;
  /// Returns the position of the next message. Messages that other threads protect meanwhile may
  /// count as passed. Under a ReadGuard.
  SendPosition position() const;
  /// Returns the number of AES blocks reserved so far, counting finished sessions as full. Under a
  /// ReadGuard.
  std::uint64_t blocks_used() const;

 private:
  SendKey(KeyMaterial material, KindTraits traits, SendStart start, const KeyServices& services)
      : material_(std::move(material)),
        traits_(traits),
        services_(services),
        start_(start),
        generation_(services.generation.current()) {}
  Result<std::unique_ptr<SendSession>> first_session() const;
  Result<std::unique_ptr<SendSession>> session_after(const SendSession& former) const;
  Status expand(SendSession& session) const;
  /// Changes to the next session, or to the first one, unless another thread already did.
  Status roll_over(const SendSession* former);

  const KeyMaterial material_;
  const KindTraits traits_;
  const KeyServices& services_;
  const SendStart start_;
  const std::uint64_t generation_;         // generation of the process that drew the start
  PublishedPointer<SendSession> current_;  // nullptr before the first message
  std::mutex mutex_;                       // held while changing to the next session
};

/// The receiver-specific key that a local sender has for one remote receiver (DDS-Security 1.2,
/// clause 10.5.3.3.3), expanded for the sender's current session.
class ReceiverKey final : public RetirableObject {
 public:
  ReceiverKey(KeyId id, MasterReceiverKey key, const KeyServices& services)
      : id_(id), key_(std::move(key)), services_(services) {}

  KeyId id() const { return id_; }
  const MasterReceiverKey& master() const { return key_; }

  /// Writes the GMAC of `common_mac` for this receiver. `sender` and `reservation` belong together.
  /// Under a ReadGuard. Error: internal.
  Status mac(const SendKey& sender, const SendKey::Reservation& reservation, TagView common_mac,
             TagOut out);

 private:
  /// The derivation uses the sender's salt, so the same session number under another revision is a
  /// different session.
  struct Session final : RetirableObject {
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
  const KeyServices& services_;
  PublishedPointer<Session> current_;
  std::mutex mutex_;  // held while expanding
};

}  // namespace ddssec::cryptography
