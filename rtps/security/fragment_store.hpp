// Puts fragmented messages of the stateless endpoint together. Anybody may send them, so little is
// kept of each sender and of all.
#pragma once

#include <deque>

#include "rtps/wire/data_frag.hpp"

namespace ddssec::rtps {

class FragmentStore {
 public:
  /// Certificates, permissions and more fit.
  static constexpr std::uint32_t kLargestMessage = 256 << 10;
  static constexpr std::size_t kMostPerSender = 2;
  static constexpr std::size_t kMost = 32;

  /// The whole message, once its last fragment came. The oldest unfinished one gives way to a new
  /// one, those of the same sender first.
  std::optional<Bytes> add(const GuidPrefix& sender, const DataFrag& frag);
  void forget(const GuidPrefix& sender);
  std::size_t size() const { return partial_.size(); }

 private:
  struct Partial {
    GuidPrefix sender;
    SequenceNumber number;
    std::uint16_t fragment_size = 0;
    Bytes octets;
    std::vector<bool> have;
    std::size_t missing = 0;
  };
  std::deque<Partial>::iterator place_for(const GuidPrefix& sender, const DataFrag& frag);

  std::deque<Partial> partial_;
};

}  // namespace ddssec::rtps
