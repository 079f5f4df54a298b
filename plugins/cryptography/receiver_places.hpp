// Limits the number of remote receivers of a sender with origin authentication. Each of its
// messages has a MAC for each receiver, and a datagram has room for about three thousand. With more
// receivers, none would get any message.
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "base/result.hpp"
#include "plugins/cryptography/subject_id.hpp"

namespace ddssec::cryptography {

/// The places of the readers of a writer, or of the participants that receive RTPS messages. Not
/// thread-safe.
class ReceiverPlaces {
 public:
  /// This many MACs leave 3,000 octets of a UDP datagram for the rest.
  static constexpr std::size_t kMax = 3125;
  /// The limit for readers, and the one for participants, if RTPS messages have origin
  /// authentication. A message may then carry MACs of both levels, and both together leave 5,500
  /// octets for the rest.
  static constexpr std::size_t kMaxOfEach = 1500;
  /// Returns the limit for one certificate. Each of its participants has a reader for every secure
  /// builtin topic.
  static constexpr std::size_t share_of(std::size_t limit) { return limit / 5; }

  /// `of` names the receivers in events.
  explicit ReceiverPlaces(std::size_t limit = kMax, std::string_view of = "readers of a writer")
      : max_(limit), of_(of) {}

  /// Takes a place for one more receiver of a certificate's subject. Error: receiver_places_taken.
  Status claim(SubjectId subject);
  void release(SubjectId subject) noexcept;
  /// Releases the place if there is one; `place` is empty afterwards.
  void release(std::optional<SubjectId>& place) noexcept {
    if (const auto taken = std::exchange(place, std::nullopt)) release(*taken);
  }

 private:
  std::unexpected<Error> limit_error(std::size_t limit, std::string_view whose) const;

  std::size_t max_;
  std::string_view of_;
  std::unordered_map<SubjectId, std::size_t> of_subject_;
  std::size_t all_ = 0;
};

}  // namespace ddssec::cryptography
