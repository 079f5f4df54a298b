// Limits the pairs of one local endpoint that have keys without being matched.
#pragma once

#include <array>
#include <list>
#include <map>
#include <optional>

#include "rtps/budget/subject_shares.hpp"

namespace ddssec::rtps {

/// A peer decides how many of its endpoints we create keys for: it announces them, and then sends
/// no keys, lets their readers fall silent, or announces that they do not match any more. So each
/// certificate subject has a limit here. If there is one more, the oldest pair of that subject
/// gives up its keys.
class IdlePairs {
 public:
  /// Why a pair has keys without being matched. Each reason has a limit of its own: anyone may be
  /// able to announce endpoints in a peer's name, but only the peer can send its keys.
  enum class IdleReason : std::uint8_t {
    keys_awaited,  ///< the remote endpoint has not sent its keys
    suspended,     ///< the remote endpoint has sent its keys, and may match again
    silent,        ///< the remote reader does not answer
  };
  /// Limit for the pairs of one subject and one reason.
  static constexpr std::size_t kMaxOfOne = 1024;

  /// Notes that the pair is idle from now on, for that reason only. Returns the pair whose keys
  /// must be given up in exchange, which is removed from here. Empty if there is room.
  std::optional<Guid> add(const Guid& remote, IdleReason why);
  /// Removes the pair, because it is matched or gone. No effect if it is not idle.
  void remove(const Guid& remote);
  /// True if pairs of that subject had to give up their keys.
  bool has_displaced(const GuidPrefix& subject) const;
  /// Returns the number of idle pairs.
  std::size_t size() const { return places_.size(); }

 private:
  using Queue = std::list<Guid>;
  struct Share {
    std::array<Queue, 3> queues = {};  ///< by reason, the oldest pair first
    bool has_displaced = false;
  };
  struct Place {
    IdleReason why;
    Queue::iterator at;
  };

  std::map<SubjectShares::Subject, Share> shares_;
  std::map<Guid, Place> places_;
};

}  // namespace ddssec::rtps
