// Which key tokens of a peer the host waits for. The host says so when it sends our own: it has
// then matched the two endpoints that its message names.
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <map>
#include <utility>

#include "base/ids.hpp"

namespace ddssec::cryptography {

/// The two endpoints, or participants, that key tokens are for.
struct TokenKey {
  Guid remote;  ///< whose tokens
  Guid local;   ///< the receiver
  auto operator<=>(const TokenKey&) const = default;
};

/// For a host that has matched two endpoints and holds a ticket for them, coming with it is a
/// matter of microseconds. So it cannot have any ticket for those that are still here after a
/// while. Not thread-safe.
class AwaitedTokens {
 public:
  using Time = std::chrono::nanoseconds;
  /// How long tokens are awaited before it is asked what became of them, and how often `review`
  /// was called meanwhile: a process that was stopped has not waited.
  static constexpr std::chrono::seconds kPatience{20};
  static constexpr unsigned kLeastReviews = 10;
  /// Of all exchanges. Further ones are not noted: where discovery is not protected, a stranger can
  /// invent endpoints.
  static constexpr std::size_t kMost = 16384;

  /// The host has matched the two in that exchange and has no keys.
  void await(std::uint64_t exchange, const TokenKey& key, Time now);
  /// The host came with a ticket for them.
  void came(std::uint64_t exchange, const TokenKey& key);
  void end(std::uint64_t exchange);
  bool contains(std::uint64_t exchange, const TokenKey& key) const;

  /// Calls `is_undecided(key, since)` for each of the exchange that was awaited long enough, and
  /// forgets it unless that returns true. To be called about once a second.
  template <class F>
  void review(std::uint64_t exchange, Time now, F&& is_undecided) {
    for (auto at = first_of(exchange); at != awaited_.end() && at->first.first == exchange;) {
      const auto one = at++;
      auto& [since, reviews] = one->second;
      if (++reviews < kLeastReviews || now - since < kPatience) continue;
      if (!is_undecided(one->first.second, since)) awaited_.erase(one);
    }
  }
  /// Calls `f(key, since)` for each of the exchange.
  template <class F>
  void each(std::uint64_t exchange, F&& f) {
    for (auto at = first_of(exchange); at != awaited_.end() && at->first.first == exchange; ++at)
      f(at->first.second, at->second.since);
  }

 private:
  struct Waiting {
    Time since;
    unsigned reviews = 0;
  };
  using All = std::map<std::pair<std::uint64_t, TokenKey>, Waiting>;
  All::iterator first_of(std::uint64_t exchange) { return awaited_.lower_bound({exchange, {}}); }

  All awaited_;
};

}  // namespace ddssec::cryptography
