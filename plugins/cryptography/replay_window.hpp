// Detects replayed messages under one key. ddssec senders count their IVs upwards
// (send_position.hpp), and with origin authentication only the sender can produce a message with a
// given IV. Without it, each holder of the shared key could move the window, so that the next
// messages of the honest sender would count as replayed.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <vector>

#include "plugins/cryptography/aead.hpp"
#include "plugins/cryptography/send_position.hpp"

namespace ddssec::cryptography {

/// The window of one key. Thread-safe.
class ReplayWindow {
 public:
  /// A late message is accepted unless this many messages that were protected after it came before
  /// it.
  static constexpr std::size_t kMaxLate = 256;
  /// The largest number of streams: a process has one stream of sessions under a key, and each
  /// child of fork() has one.
  static constexpr std::size_t kMaxStreams = 8;

  /// False if the message came before, or is too late to tell. Call it after all MACs were right.
  bool accept(const Iv& iv);

 private:
  /// The messages of one sequence of sessions that count up.
  class Stream {
   public:
    explicit Stream(IvParts first) : newest_(kMaxLate) { accept(first); }
    /// True if the session is close to the stream's newest one.
    bool has(std::uint32_t session) const;
    bool accept(IvParts message);

   private:
    /// Returns the remembered message at index `at`, counted from the oldest.
    IvParts& place(std::size_t at) { return newest_[(first_ + at) % kMaxLate]; }

    std::vector<IvParts> newest_;  ///< a ring, in the order in which they were protected
    std::size_t first_ = 0, size_ = 0;
    std::optional<IvParts> passed_;  ///< messages up to this one are refused
  };

  std::mutex mutex_;
  std::vector<Stream> streams_;
};

}  // namespace ddssec::cryptography
