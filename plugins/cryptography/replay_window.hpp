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
#include "plugins/cryptography/send_position.hpp"

namespace ddssec::cryptography {

/// Any number of threads.
class ReplayWindow {
 public:
  /// A message is accepted late as long as fewer others than this came before it.
  static constexpr std::size_t kMaxLate = 128;
  /// A process has one stream of sessions under a key, and so has each child of fork().
  static constexpr std::size_t kMaxStreams = 8;

  /// To be called once all MACs were right. False: the message came before, or is too late to tell.
  bool accept(const Iv& iv);

 private:
  /// The messages of sessions that count up.
  class Stream {
   public:
    explicit Stream(IvParts first) : newest_(first) { recent_.push_back(first); }
    /// Does the session lie close to the stream's newest one?
    bool has(std::uint32_t session) const;
    bool accept(IvParts message);

   private:
    IvParts newest_;
    std::optional<IvParts> passed_;  ///< the newest of those that are not remembered any more
    std::vector<IvParts> recent_;    ///< in the order of arrival, a ring
    std::size_t oldest_ = 0;         ///< of the ring, once it is full
  };

  std::mutex mutex_;
  std::vector<Stream> streams_;
};

}  // namespace ddssec::cryptography
