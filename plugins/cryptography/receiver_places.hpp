// How many remote receivers a sender with origin authentication serves. Each of its messages has a
// MAC for each of them, and a datagram has room for some three thousand: with more of them, none
// would get anything.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>
#include <unordered_map>

#include "base/result.hpp"

namespace ddssec::cryptography {

/// The readers of a writer, or the participants that RTPS messages are for.
class ReceiverPlaces {
 public:
  /// This many MACs leave 3,000 octets of a UDP datagram for the rest.
  static constexpr std::size_t kMost = 3125;
  /// Of readers, and of participants, where RTPS messages have origin authentication: a message may
  /// carry MACs of both levels. Twice as many leave 5,500 octets for the rest.
  static constexpr std::size_t kMostOfEach = 1500;
  /// Of one certificate. Each of its participants has a reader of every secure builtin topic.
  static constexpr std::size_t share_of(std::size_t most) { return most / 5; }

  /// `of` stands in events.
  explicit ReceiverPlaces(std::size_t most = kMost, std::string_view of = "readers of a writer")
      : most_(most), of_(of) {}

  /// For one more receiver of a certificate's subject. Error: receiver_places_taken.
  Status take(std::uint64_t subject);
  void give_back(std::uint64_t subject) noexcept;

 private:
  std::unexpected<Error> refuse(std::size_t most, std::string_view whose) const;

  std::size_t most_;
  std::string_view of_;
  std::unordered_map<std::uint64_t, std::size_t> of_subject_;
  std::size_t all_ = 0;
};

}  // namespace ddssec::cryptography
