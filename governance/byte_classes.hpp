// The alphabet of an automaton over expressions: octets that no expression distinguishes are one
// letter.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <string>
#include <vector>

namespace ddssec::governance {

/// Returns every octet but NUL, the most readable first.
const std::string& octets_by_readability();

/// Classes of octets, numbered so that classes with readable octets come first: letters, then the
/// others.
class ByteClasses {
 public:
  using Class = std::uint8_t;
  /// The class of NUL, which occurs in no name, if it is alone in its class.
  static constexpr Class kNone = 255;

  /// From now on octets inside and outside the set are in different classes.
  void separate(const std::bitset<256>& set);
  /// From now on the octet is alone in its class.
  void separate(std::uint8_t octet) { single_.set(octet); }
  /// Numbers the classes. Call it after all separate().
  void number();

  std::size_t size() const { return shown_.size(); }
  Class of(std::uint8_t octet) const { return class_[octet]; }
  /// Returns the most readable octet of the class.
  char shown(Class c) const { return static_cast<char>(shown_[c]); }

 private:
  std::bitset<256> single_;
  std::array<std::uint16_t, 256> group_{};
  std::array<Class, 256> class_{};
  std::vector<std::uint8_t> shown_;
};

}  // namespace ddssec::governance
