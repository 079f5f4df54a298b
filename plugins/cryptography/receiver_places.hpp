// How many remote readers a writer with origin authentication serves. Each of its messages has a
// MAC for each of them, and a datagram has room for some three thousand: with more of them, none
// would get anything.
#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "base/result.hpp"

namespace ddssec::cryptography {

class ReceiverPlaces {
 public:
  /// This many MACs leave 3,000 octets of a UDP datagram for the rest.
  static constexpr std::size_t kMost = 3125;
  /// As many as one certificate may have participants, each of which has a reader of every secure
  /// builtin topic.
  static constexpr std::size_t kMostOfSubject = kMost / 5;

  /// For one more reader of a certificate's subject. Error: receiver_count.
  Status take(std::uint64_t subject);
  void give_back(std::uint64_t subject) noexcept;

 private:
  std::unordered_map<std::uint64_t, std::size_t> of_subject_;
  std::size_t all_ = 0;
};

}  // namespace ddssec::cryptography
