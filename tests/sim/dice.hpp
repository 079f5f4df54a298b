// Everything that is random in a simulation, from one seed.
#pragma once

#include <cstdint>
#include <string_view>

#include "base/bytes.hpp"

namespace ddssec::rtps::sim {

/// The generator splitmix64. No distribution of std is used, because their results differ between
/// libraries.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  /// Returns an independent stream for one purpose: draws elsewhere do not change it.
  Dice fork(std::string_view purpose) const {
    auto seed = state_ ^ 0x5851f42d4c957f2d;
    for (const auto letter : purpose) seed = mix(seed + static_cast<unsigned char>(letter));
    return Dice(mix(seed));
  }

  std::uint64_t next() { return mix(state_ += 0x9e3779b97f4a7c15); }
  /// Returns 0 to `limit` - 1; 0 if there is nothing to choose from.
  std::size_t below(std::size_t limit) { return limit == 0 ? 0 : next() % limit; }
  bool chance(unsigned in_thousand) { return below(1000) < in_thousand; }
  std::uint8_t octet() { return static_cast<std::uint8_t>(next()); }
  Bytes octets(std::size_t count) {
    Bytes out(count);
    for (auto& one : out) one = octet();
    return out;
  }
  /// Returns an element of `list`, which must not be empty.
  template <class List>
  auto& of(List&& list) {
    return list[below(list.size())];
  }

 private:
  static std::uint64_t mix(std::uint64_t value) {
    value = (value ^ value >> 30) * 0xbf58476d1ce4e5b9;
    value = (value ^ value >> 27) * 0x94d049bb133111eb;
    return value ^ value >> 31;
  }
  std::uint64_t state_;
};

}  // namespace ddssec::rtps::sim
