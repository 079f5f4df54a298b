// Pairs of a local and a remote participant whose handshake is not begun for a while.
#pragma once

#include <chrono>
#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/ids.hpp"
#include "plugins/spi/handles.hpp"

namespace ddssec::cyclonedds {

/// To begin one handshake again, the host ends the sessions of the remote participant with all
/// local ones. Where another local participant has such a session, a pair that never finishes its
/// handshake is begun again at once the first time, and then rests: 10 minutes, 20, 40 and so on.
/// Not thread-safe. Times are by the monotonic clock.
class RestingPairs {
 public:
  using Duration = std::chrono::nanoseconds;
  static constexpr Duration kFirstRest = std::chrono::minutes(10);
  static constexpr unsigned kMostDoublings = 7;  ///< 21 hours
  static constexpr std::size_t kMost = 1024;     ///< then the rest that is over first is given up

  /// The pair did not finish its handshake. Returns how long it rests; 0: it is begun at once.
  Duration failed(spi::IdentityHandle local, const Guid& remote, Duration now);
  /// It finished its handshake.
  void finished(spi::IdentityHandle local, const Guid& remote) { pairs_.erase({local, remote}); }
  /// How long it still rests; 0: it may be begun.
  Duration remaining(spi::IdentityHandle local, const Guid& remote, Duration now) const;
  /// The remote participants of pairs whose rest is over, each pair once.
  std::vector<Guid> take_rested(Duration now);
  void forget_local(spi::IdentityHandle local);

 private:
  struct Rest {
    unsigned failures = 0;
    Duration until{};
    bool is_over = true;
  };
  std::map<std::pair<spi::IdentityHandle, Guid>, Rest> pairs_;
};

/// "10 minutes", rounded up.
std::string minutes_in(RestingPairs::Duration time);

}  // namespace ddssec::cyclonedds
