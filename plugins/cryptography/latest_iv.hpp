// How far a sender has come with a key, so that what was recorded in one session with it is not new
// in the next. A peer that authenticates again brings the same keys: they belong to the peer, not
// to the session. Our senders count their IVs upwards; other products' need not.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "base/hash.hpp"
#include "plugins/cryptography/aead.hpp"
#include "plugins/cryptography/key_material.hpp"

namespace ddssec::cryptography {

/// The latest IV of one key. Any number of threads; a message costs a load, and a store if its IV
/// is the latest.
///
/// An IV says a session and a block in it. Both are counted from those of the first message, modulo
/// their sizes. A sender that leaves the range of 2^23 sessions or 2^39 blocks has no order any
/// more, as a forked process, which begins elsewhere.
class LatestIv {
 public:
  /// Greater for a later IV; 0 is before all.
  using Place = std::uint64_t;

  /// 0 before the first message, and of a sender without order.
  Place latest() const noexcept;
  /// Nothing before the first message, and for an IV out of range.
  std::optional<Place> place_of(const Iv& iv) const noexcept;
  /// To be called once the tags of the message were right.
  void note(const Iv& iv) noexcept;

 private:
  struct Position {
    std::uint32_t session;
    std::uint64_t block;
  };
  static Position position_of(const Iv& iv) noexcept;
  void begin(const Position& first) noexcept;

  std::atomic<bool> has_begun_ = false;
  std::atomic<bool> has_order_ = true;
  std::mutex beginning_;
  Position first_{};  ///< constant once has_begun_
  std::atomic<Place> latest_ = 0;
};

/// By key, beyond the sessions in which the keys are used. One caller at a time.
class LatestIvs {
 public:
  /// Of the keys of one certificate's participants, which are told by the first six octets of the
  /// prefix (DDS-Security 9.3.3). With more keys, the first ones are forgotten.
  static constexpr std::size_t kMostOfSubject = 4096;
  using Subject = std::array<std::uint8_t, 6>;

  /// That of the key: the same each time it comes.
  std::shared_ptr<LatestIv> of(const Subject& subject, const KeyMaterial& key);

 private:
  struct Keys {
    std::map<Sha256Digest, std::shared_ptr<LatestIv>>
        by_digest;                     ///< not by keys: this outlives them
    std::list<Sha256Digest> in_order;  ///< in which they came
  };
  std::map<Subject, Keys> subjects_;
};

}  // namespace ddssec::cryptography
