// The receiving side of one key: the sessions of a remote sender, expanded and remembered.
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

/// The expanded keys of a remote session. `receiver` is nullptr if there is no receiver-specific
/// key.
struct ReceiveSession final : RetirableObject {
  SessionId id;
  ExpandedKey key;
  std::unique_ptr<ExpandedKey> receiver;
  std::atomic<std::uint32_t> last_used = 0;
};

/// The position of the sender when it gave its key to the last local endpoint that has it. The host
/// passes each message to all these endpoints, so a message that is old for one is old for all.
class NewestPosition {
 public:
  explicit NewestPosition(SendPosition position)
      : newest_(std::make_unique<Place>(std::move(position))) {}

  /// True if a message with that IV was protected before this position. Under a ReadGuard.
  bool has_passed(const Iv& iv) const noexcept { return newest_.read()->position.has_passed(iv); }
  /// Moves on to the position in another copy of the same key, given to another endpoint, if that
  /// is newer. One caller at a time.
  void note(const NewestPosition& other, RetiredObjects& retired_objects);

 private:
  struct Place final : RetirableObject {
    explicit Place(SendPosition at) : position(std::move(at)) {}
    const SendPosition position;
  };
  PublishedPointer<Place> newest_;
};

/// Decrypts and verifies messages that one remote entity sends with one key. Any number of threads
/// may use it.
///
/// The sender, or an attacker, chooses the session id of a message. So a session is remembered only
/// after a tag under it was right, and at most kMaxSessions are remembered. A hit reads
/// kMaxSessions pointers and writes nothing (except once after each new session, for the order of
/// use). A miss costs a derivation and a key expansion. Fast DDS changes its session every 32
/// messages. So the object of a dropped session is set aside and used again for the next one, and
/// nothing is allocated.
class ReceiveKey final : public RetirableObject {
 public:
  static constexpr std::size_t kMaxSessions = 4;

  ReceiveKey(KeyMaterial material, KindTraits traits, const KeyServices& services)
      : position_(position_of(std::exchange(material.position, std::nullopt))),
        material_(std::move(material)),
        traits_(traits),
        services_(services) {
    if (position_ && material_.has_receiver_key()) window_ = std::make_shared<ReplayWindow>();
  }

  const KeyMaterial& material() const { return material_; }
  const KindTraits& traits() const { return traits_; }

  /// A session for trying a message. Valid under a ReadGuard. A new one is not remembered yet.
  class Candidate {
   public:
    const ReceiveSession* operator->() const { return session_; }

   private:
    friend class ReceiveKey;
    const ReceiveSession* session_ = nullptr;
    std::unique_ptr<ReceiveSession> fresh_;
  };
  /// Returns the session with that id. It is expanded now if it is not remembered. Error: internal.
  Result<Candidate> session(SessionId id);
  /// Remembers the session. Call it after the tags were right.
  void remember(Candidate candidate);

  /// True if the message was protected before its sender gave the key to all local endpoints that
  /// have it. Under a ReadGuard.
  bool precedes_key_exchange(const Iv& iv) const { return position_ && position_->has_passed(iv); }
  /// True if the message came before. Call it after the tags were right. Only senders that use
  /// ddssec with origin authentication are checked (replay_window.hpp).
  bool is_repeated(const Iv& iv) { return window_ && !window_->accept(iv); }
  /// Continues with the state of `first`, because the same key came once more. Messages that are
  /// under way stay valid. Call it before publication.
  void count_from(const ReceiveKey& first) {
    position_ = first.position_;
    window_ = first.window_;
  }
  /// Shares the position of `other`, the key of the same sender for another endpoint. Messages that
  /// are under way to that endpoint are lost; a reliable sender repeats them. Call it before
  /// publication, one caller at a time.
  void count_with(const ReceiveKey& other) { count_with(other.position_); }
  void count_with(const std::shared_ptr<NewestPosition>& of_other);
  /// Shares the window of the same key at another place, if the host takes each message only once.
  /// A message that one of them accepted is then a repetition for all. Call it before publication.
  void share_window(const ReceiveKey& other) {
    if (window_ && other.window_) window_ = other.window_;
  }
  /// Returns the sender's position; nullptr if the sender did not send it.
  const std::shared_ptr<NewestPosition>& position() const { return position_; }

 private:
  struct ReplacedSession {
    std::unique_ptr<ReceiveSession> session;
    std::uint64_t epoch = 0;
  };
  std::unique_ptr<ReceiveSession> blank();
  PublishedPointer<ReceiveSession>& place_for_next();

  static std::shared_ptr<NewestPosition> position_of(std::optional<SendPosition> said) {
    return said ? std::make_shared<NewestPosition>(std::move(*said)) : nullptr;
  }

  std::shared_ptr<NewestPosition> position_;  ///< nullptr if the sender did not send it
  std::shared_ptr<ReplayWindow> window_;      ///< nullptr if replay is not checked
  const KeyMaterial material_;
  const KindTraits traits_;
  const KeyServices& services_;
  std::array<PublishedPointer<ReceiveSession>, kMaxSessions> sessions_;
  std::atomic<std::uint32_t> time_ = 0;  // counts remembered sessions
  std::mutex mutex_;                     // guards aside_ and writing to sessions_
  ReplacedSession aside_;
};

}  // namespace ddssec::cryptography
