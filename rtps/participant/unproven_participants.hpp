// The participants that have proven nothing, shared out among the addresses that announced them.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>

#include "base/ids.hpp"
#include "rtps/budget/source_address.hpp"

namespace ddssec::rtps {

/// Counts participants and the octets of their announcements by source address. When there is no
/// room, the source that holds most gives way first.
class UnprovenParticipants {
 public:
  /// Of the announcements of all of them.
  static constexpr std::size_t kMaxOctets = std::size_t{4} << 20;

  void add(const SourceAddress& source, const GuidPrefix& prefix, std::size_t octets);
  void remove(const SourceAddress& source, std::size_t octets);
  /// The announcement of one of them took so many octets more.
  void grow(const SourceAddress& source, std::size_t more);
  bool has_room(std::size_t octets) const { return octets_ + octets <= kMaxOctets; }

  /// The source that holds most participants, or if `by_octets` most octets; `newcomer` if it holds
  /// as much. Of equal ones the source that announced one longest ago. Nothing: there are none.
  std::optional<SourceAddress> largest(const SourceAddress& newcomer, bool by_octets) const;
  /// Of that source, the participant that announced itself longest ago and for which
  /// `is_silent(prefix)`. Nothing: there is none.
  std::optional<GuidPrefix> oldest_silent(const SourceAddress& source,
                                          const std::function<bool(const GuidPrefix&)>& is_silent);

 private:
  /// More may be waiting that are not there any more.
  static constexpr std::size_t kMaxSilent = 2048;
  struct Share {
    std::size_t count = 0;
    std::size_t octets = 0;
    std::uint64_t since = 0;  ///< number of the announcement that opened the share
    /// In the order of their announcements; some have spoken since, or left.
    std::deque<GuidPrefix> silent = {};
  };

  std::map<SourceAddress, Share> shares_;
  std::size_t octets_ = 0;
  std::uint64_t announcements_ = 0;
};

}  // namespace ddssec::rtps
