// Which messages under one key have come already. Our senders count their IVs upwards
// (send_position.hpp), and with origin authentication only the sender can make a message with an
// IV. Without it each holder of the shared key could move the window, and so make what the honest
// sender says next count as repeated.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "plugins/cryptography/aead.hpp"

namespace ddssec::cryptography {

/// Any number of threads.
class ReplayWindow {
 public:
  /// A message is accepted late as long as fewer others than this came before it.
  static constexpr std::size_t kMaxLate = 256;
  /// A process has one stream of sessions under a key, and so has each child of fork().
  static constexpr std::size_t kMaxStreams = 8;

  /// To be called once all MACs were right. False: the message came before, or is too late to tell.
  bool accept(const Iv& iv);

 private:
  /// Sessions that count up, and the messages of the newest one.
  class Stream {
   public:
    Stream(std::uint32_t session, std::uint64_t suffix) { begin(session, suffix); }
    /// How far `session` is ahead of the stream's; negative: behind it.
    std::int32_t distance(std::uint32_t session) const {
      return static_cast<std::int32_t>(session - session_);
    }
    void begin(std::uint32_t session, std::uint64_t suffix);
    bool accept(std::uint64_t suffix);

   private:
    std::uint32_t session_ = 0;
    std::uint64_t newest_ = 0;             ///< greatest suffix
    std::optional<std::uint64_t> passed_;  ///< greatest that is not remembered any more
    std::vector<std::uint64_t> recent_;    ///< suffixes in the order of arrival, a ring
    std::size_t oldest_ = 0;               ///< of the ring, once it is full
  };

  std::mutex mutex_;
  std::vector<Stream> streams_;
};

}  // namespace ddssec::cryptography
