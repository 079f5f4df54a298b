// The key token messages that went to a peer in fragments. A later fragment does not name the
// message's destination.
#pragma once

#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

namespace ddssec::cryptography {

/// The numbers (writerSN) of the key token messages that one peer was sent in fragments.
/// Thread-safe.
class FragmentedTokens {
 public:
  /// The largest number of entries; the oldest one is then forgotten. Only messages of the local
  /// host add entries.
  static constexpr std::size_t kMax = 1024;

  void note(std::uint64_t number);
  bool contains(std::uint64_t number) const;

 private:
  mutable std::mutex mutex_;
  std::vector<std::uint64_t> numbers_;
  std::size_t oldest_ = 0;  ///< the position that is overwritten next, once there are kMax
};

}  // namespace ddssec::cryptography
