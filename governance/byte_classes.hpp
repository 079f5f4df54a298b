// The alphabet of an automaton over expressions: octets that nothing tells apart are one letter.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <string>
#include <vector>

namespace ddssec::governance {

/// Every octet but NUL, the most readable first.
const std::string& octets_by_readability();

/// Classes of octets, numbered in the order in which people like to read names: letters first.
class ByteClasses {
 public:
  using Class = std::uint8_t;
  /// Of NUL, which no name holds, if nothing else is in its class.
  static constexpr Class kNone = 255;

  void tell_apart(const std::bitset<256>& set);
  void tell_apart(std::uint8_t octet) { single_.set(octet); }
  /// After all tell_apart().
  void number();

  std::size_t size() const { return shown_.size(); }
  Class of(std::uint8_t octet) const { return class_[octet]; }
  /// The most readable octet of the class.
  char shown(Class c) const { return static_cast<char>(shown_[c]); }

 private:
  std::bitset<256> single_;
  std::array<std::uint16_t, 256> group_{};
  std::array<Class, 256> class_{};
  std::vector<std::uint8_t> shown_;
};

}  // namespace ddssec::governance
