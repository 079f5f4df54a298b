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
  /// A message is accepted late unless so many others that were protected after it came before it.
  static constexpr std::size_t kMaxLate = 256;
  /// A process has one stream of sessions under a key, and so has each child of fork().
  static constexpr std::size_t kMaxStreams = 8;

  /// To be called once all MACs were right. False: the message came before, or is too late to tell.
  bool accept(const Iv& iv);

 private:
  /// The messages of sessions that count up.
  class Stream {
   public:
    explicit Stream(IvParts first) : newest_(kMaxLate) { accept(first); }
    /// Does the session lie close to the stream's newest one?
    bool has(std::uint32_t session) const;
    bool accept(IvParts message);

   private:
    /// Counted from the oldest of those that are remembered.
    IvParts& place(std::size_t at) { return newest_[(first_ + at) % kMaxLate]; }

    std::vector<IvParts> newest_;  ///< a ring, in the order in which they were protected
    std::size_t first_ = 0, size_ = 0;
    std::optional<IvParts> passed_;  ///< nothing up to this one counts any more
  };

  std::mutex mutex_;
  std::vector<Stream> streams_;
};

}  // namespace ddssec::cryptography
