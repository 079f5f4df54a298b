// The receiver's side of one key: the sessions of a remote sender, expanded and remembered.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <mutex>

#include "plugins/cryptography/aead.hpp"
#include "plugins/cryptography/derivation.hpp"
#include "plugins/cryptography/latest_iv.hpp"
#include "plugins/cryptography/reclaim.hpp"
#include "plugins/cryptography/send_key.hpp"

namespace ddssec::cryptography {

/// A remote session's keys, expanded. `receiver` is empty without a receiver-specific key.
struct ReceiveSession final : Retirable {
  SessionId id;
  ExpandedKey key;
  std::unique_ptr<ExpandedKey> receiver;
  std::atomic<std::uint32_t> last_used = 0;
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

  /// `latest`: the latest IV of this key in former sessions, if its sender counts IVs upwards;
  /// else null.
  ReceiveKey(KeyMaterial material, KindTraits traits, const KeyEnvironment& environment,
             std::shared_ptr<LatestIv> latest = nullptr)
      : material_(std::move(material)),
        traits_(traits),
        environment_(environment),
        latest_(std::move(latest)),
        before_(latest_ ? latest_->latest() : 0) {}

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

  /// Is the IV not later than what came in former sessions with the sender?
  bool is_of_former_session(const Iv& iv) const {
    if (before_ == 0) return false;
    const auto place = latest_->place_of(iv);
    return place && *place <= before_;
  }
  /// To be called once the tags were right.
  void note(const Iv& iv) {
    if (latest_) latest_->note(iv);
  }

 private:
  struct Aside {
    std::unique_ptr<ReceiveSession> session;
    std::uint64_t epoch = 0;
  };
  std::unique_ptr<ReceiveSession> blank();
  Published<ReceiveSession>& place_for_next();

  const KeyMaterial material_;
  const KindTraits traits_;
  const KeyEnvironment& environment_;
  const std::shared_ptr<LatestIv> latest_;
  const LatestIv::Place before_;  ///< 0: nothing came before
  std::array<Published<ReceiveSession>, kMostSessions> sessions_;
  std::atomic<std::uint32_t> time_ = 0;  // counts remembered sessions
  std::mutex mutex_;                     // guards aside_ and writing to sessions_
  Aside aside_;
};

}  // namespace ddssec::cryptography
