// Tracks which key tokens of a peer the host waits for. The host shows this when it sends the local
// tokens: it has then matched the two endpoints that its message names.
#pragma once

#include <chrono>
#include <compare>
#include <cstdint>
#include <map>
#include <utility>

#include "base/ids.hpp"
#include "plugins/cryptography/subject_id.hpp"

namespace ddssec::cryptography {

/// The two endpoints, or two participants, between which key tokens go.
struct TokenKey {
  Guid remote;  ///< the sender of the tokens
  Guid local;   ///< the receiver
  auto operator<=>(const TokenKey&) const = default;
};

/// The awaited tokens. A host that has matched two endpoints and holds a ticket for them presents
/// it within microseconds. So if tokens are still awaited after a while, the host cannot have a
/// ticket for them. Not thread-safe.
class AwaitedTokens {
 public:
  using Time = std::chrono::nanoseconds;
  /// For how long tokens are awaited before `review` asks about them, and how often `review` must
  /// have been called meanwhile. The second condition exists because a process that was stopped has
  /// not waited.
  static constexpr std::chrono::seconds kTokenTimeout{20};
  static constexpr unsigned kMinReviews = 10;
  /// The largest numbers of entries for the participants of one certificate, which are identified
  /// by the first six octets of the prefix (DDS-Security 1.2, clause 10.3.3), and for all; further
  /// ones are not recorded. If discovery is not protected, an attacker can invent endpoints.
  static constexpr std::size_t kMaxOfSubject = 16384;
  static constexpr std::size_t kMax = 4 * kMaxOfSubject;

  /// Notes that the host has matched the two endpoints in that exchange and has no keys yet.
  void await(std::uint64_t exchange, const TokenKey& key, Time now);
  /// Notes that the host presented a ticket for them.
  void came(std::uint64_t exchange, const TokenKey& key);
  /// Removes all entries of an exchange that has ended.
  void end(std::uint64_t exchange);
  bool contains(std::uint64_t exchange, const TokenKey& key) const;

  /// Calls `is_undecided(key, since)` for each entry of the exchange that was awaited long enough,
  /// and removes the entry unless that returns true. Call it about once a second.
  template <class F>
  void review(std::uint64_t exchange, Time now, F&& is_undecided) {
    for (auto at = first_of(exchange); at != awaited_.end() && at->first.first == exchange;) {
      const auto one = at++;
      auto& [since, reviews] = one->second;
      if (++reviews < kMinReviews || now - since < kTokenTimeout) continue;
      if (!is_undecided(one->first.second, since)) erase(one);
    }
  }
  /// Calls `f(key, since)` for each entry of the exchange.
  template <class F>
  void each(std::uint64_t exchange, F&& f) {
    for (auto at = first_of(exchange); at != awaited_.end() && at->first.first == exchange; ++at)
      f(at->first.second, at->second.since);
  }

 private:
  struct Wait {
    Time since;
    unsigned reviews = 0;
  };
  using All = std::map<std::pair<std::uint64_t, TokenKey>, Wait>;
  All::iterator first_of(std::uint64_t exchange) { return awaited_.lower_bound({exchange, {}}); }
  void erase(All::iterator entry);

  All awaited_;
  std::map<SubjectId, std::size_t> of_subject_;
};

}  // namespace ddssec::cryptography
