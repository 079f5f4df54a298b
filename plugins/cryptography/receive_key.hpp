// The receiver's side of one key: the sessions of a remote sender, expanded and remembered.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "plugins/cryptography/aead.hpp"
#include "plugins/cryptography/derivation.hpp"
#include "plugins/cryptography/reclaim.hpp"
#include "plugins/cryptography/replay_window.hpp"
#include "plugins/cryptography/send_key.hpp"

namespace ddssec::cryptography {

/// A remote session's keys, expanded. `receiver` is empty without a receiver-specific key.
struct ReceiveSession final : Retirable {
  SessionId id;
  ExpandedKey key;
  std::unique_ptr<ExpandedKey> receiver;
  std::atomic<std::uint32_t> last_used = 0;
};

/// Where the sender of a key stood when it gave it to the last of the endpoints here that have it.
/// The host hands each message to all of them, so that what is old to one is old to all.
class NewestPosition {
 public:
  explicit NewestPosition(SendPosition position)
      : newest_(std::make_unique<Place>(std::move(position))) {}

  /// Under a ReadGuard.
  bool has_passed(const Iv& iv) const noexcept { return newest_.read()->position.has_passed(iv); }
  /// One caller at a time: of the same key, given to another endpoint.
  void note(const NewestPosition& other, Graveyard& graveyard);

 private:
  struct Place final : Retirable {
    explicit Place(SendPosition at) : position(std::move(at)) {}
    const SendPosition position;
  };
  Published<Place> newest_;
};

/// Decrypts and verifies what one remote entity sends with one key. Any number of threads.
///
/// The session id of a message is its sender's, or an attacker's, choice. So a session is
/// remembered only after a tag under it was right, and kMostSessions are. A hit costs a look at
/// kMostSessions pointers and writes nothing (but once after each new session, for the order of
/// use); a miss costs a derivation and an expansion. Fast DDS changes its session every 32
/// messages: who leaves the memory is kept aside and its place filled with the next one, so that
/// nothing is allocated then.
class ReceiveKey final : public Retirable {
 public:
  static constexpr std::size_t kMostSessions = 4;

  ReceiveKey(KeyMaterial material, KindTraits traits, const KeyEnvironment& environment)
      : position_(position_of(std::exchange(material.position, std::nullopt))),
        material_(std::move(material)),
        traits_(traits),
        environment_(environment) {
    if (position_ && material_.has_receiver_key()) window_ = std::make_shared<ReplayWindow>();
  }

  const KeyMaterial& material() const { return material_; }
  const KindTraits& traits() const { return traits_; }

  /// A session to try a message with, under a ReadGuard. Not remembered if it is new.
  class Candidate {
   public:
    const ReceiveSession* operator->() const { return session_; }

   private:
    friend class ReceiveKey;
    const ReceiveSession* session_ = nullptr;
    std::unique_ptr<ReceiveSession> fresh_;
  };
  /// Errors: internal.
  Result<Candidate> session(SessionId id);
  /// To be called once the tags were right.
  void remember(Candidate candidate);

  /// Under a ReadGuard: was the message protected before its sender gave the key to all of our
  /// endpoints that have it?
  bool is_from_before(const Iv& iv) const { return position_ && position_->has_passed(iv); }
  /// To be called once the tags were right: did the message come before? Only our senders with
  /// origin authentication are judged (replay_window.hpp).
  bool is_repeated(const Iv& iv) { return window_ && !window_->accept(iv); }
  /// Before it is published: the key came once more. What was under way meanwhile is still new.
  void count_from(const ReceiveKey& first) {
    position_ = first.position_;
    window_ = first.window_;
  }
  /// Before it is published, by one caller at a time: another endpoint has the same sender's key.
  /// What was under way to that one is lost, and a reliable sender repeats it.
  void count_with(const ReceiveKey& other) { count_with(other.position_); }
  void count_with(const std::shared_ptr<NewestPosition>& of_other);
  /// nullptr: its sender did not say.
  const std::shared_ptr<NewestPosition>& position() const { return position_; }

 private:
  struct Aside {
    std::unique_ptr<ReceiveSession> session;
    std::uint64_t epoch = 0;
  };
  std::unique_ptr<ReceiveSession> blank();
  Published<ReceiveSession>& place_for_next();

  static std::shared_ptr<NewestPosition> position_of(std::optional<SendPosition> said) {
    return said ? std::make_shared<NewestPosition>(std::move(*said)) : nullptr;
  }

  std::shared_ptr<NewestPosition> position_;  ///< null: its sender did not say
  std::shared_ptr<ReplayWindow> window_;      ///< null: not judged
  const KeyMaterial material_;
  const KindTraits traits_;
  const KeyEnvironment& environment_;
  std::array<Published<ReceiveSession>, kMostSessions> sessions_;
  std::atomic<std::uint32_t> time_ = 0;  // counts remembered sessions
  std::mutex mutex_;                     // guards aside_ and writing to sessions_
  Aside aside_;
};

}  // namespace ddssec::cryptography
