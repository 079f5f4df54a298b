// The participants that have proven nothing, counted by the address that announced them.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>

#include "base/ids.hpp"
#include "rtps/budget/source_address.hpp"

namespace ddssec::rtps {

/// Counts participants and the octets of their announcements for each source address. When there is
/// no room, participants of the source that holds the most are removed first.
class UnprovenParticipants {
 public:
  /// The limit for the octets of all announcements together.
  static constexpr std::size_t kMaxOctets = std::size_t{4} << 20;

  void add(const SourceAddress& source, const GuidPrefix& prefix, std::size_t octets);
  void remove(const SourceAddress& source, std::size_t octets);
  /// Notes that the announcement of a participant has grown by this many octets.
  void grow(const SourceAddress& source, std::size_t more);
  bool has_room(std::size_t octets) const { return octets_ + octets <= kMaxOctets; }

  /// Returns the source with the most participants, or with the most octets if `by_octets`. Returns
  /// `newcomer` if it holds as much. If several sources are equal, returns the one that announced a
  /// participant longest ago. Empty if there are none.
  std::optional<SourceAddress> largest(const SourceAddress& newcomer, bool by_octets) const;
  /// Returns the participant of that source that announced itself longest ago and for which
  /// `is_silent(prefix)` is true. Empty if there is none.
  std::optional<GuidPrefix> oldest_silent(const SourceAddress& source,
                                          const std::function<bool(const GuidPrefix&)>& is_silent);

 private:
  /// The largest size of the list of silent participants, which may contain some that no longer
  /// exist.
  static constexpr std::size_t kMaxSilent = 2048;
  struct Share {
    std::size_t count = 0;
    std::size_t octets = 0;
    std::uint64_t since = 0;  ///< number of the announcement that created the share
    /// The participants in the order of their announcements. Some have sent messages since, or have
    /// left.
    std::deque<GuidPrefix> silent = {};
  };

  std::map<SourceAddress, Share> shares_;
  std::size_t octets_ = 0;
  std::uint64_t announcements_ = 0;
};

}  // namespace ddssec::rtps
