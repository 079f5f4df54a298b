// The virtual network: datagrams that are on their way, and when each arrives.
#pragma once

#include <map>
#include <vector>

#include "base/clock.hpp"
#include "tests/sim/cast.hpp"
#include "wire/locator.hpp"

namespace ddssec::rtps::sim {

struct Datagram {
  Locator from, to;
  Bytes octets;
};

/// The address to which all participants announce themselves.
inline const Locator kGroup = Locator::udp_v4({239, 255, 0, 1}, 7400);
inline Locator address_of(std::size_t node) {
  constexpr std::size_t kOfNetwork = 250;
  return Locator::udp_v4({10, 0, static_cast<std::uint8_t>(node / kOfNetwork),
                          static_cast<std::uint8_t>(node % kOfNetwork + 1)},
                         7400);
}

class Network {
 public:
  static constexpr MonotonicTime kLatency = std::chrono::milliseconds(1);

  void post(Datagram datagram, MonotonicTime due) { under_way_.emplace(due, std::move(datagram)); }
  /// Returns the datagrams that arrive until `now`, in order.
  std::vector<Datagram> arrived(MonotonicTime now) {
    std::vector<Datagram> out;
    const auto end = under_way_.upper_bound(now);
    for (auto at = under_way_.begin(); at != end; ++at) out.push_back(std::move(at->second));
    under_way_.erase(under_way_.begin(), end);
    return out;
  }
  void lose_all() { under_way_.clear(); }

 private:
  std::multimap<MonotonicTime, Datagram> under_way_;
};

/// The interface through which participants send.
class Wire {
 public:
  virtual ~Wire() = default;
  /// Sends a datagram. `for_honest` is true if it is sent as a sample is written whose readers are
  /// all honest.
  virtual void carry(const Subject& from, Datagram datagram, bool for_honest) = 0;
};

}  // namespace ddssec::rtps::sim
