// Numbers of revocation lists.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>

#include "base/bytes.hpp"

namespace ddssec::pki {

/// The number of a revocation list, which is not negative. Lists of CAs that follow RFC 5280 5.2.3
/// have numbers of up to 20 octets. Longer ones are compared in the same way.
class CrlNumber {
 public:
  CrlNumber(std::uint64_t number = 0);  // NOLINT(google-explicit-constructor): as an integer
  /// Reads a number whose most significant octet comes first.
  static CrlNumber from_octets(BytesView octets);

  /// Returns the octets without leading zeros; empty for 0.
  BytesView octets() const { return octets_; }
  /// Returns the value; empty if it has more than 64 bits.
  std::optional<std::uint64_t> as_uint64() const;
  CrlNumber next() const;

  friend bool operator==(const CrlNumber&, const CrlNumber&) = default;
  friend std::strong_ordering operator<=>(const CrlNumber& a, const CrlNumber& b);

 private:
  Bytes octets_;
};

/// Returns decimal digits, or only the length of a number that is longer than RFC 5280 allows.
std::string to_string(const CrlNumber& number);

}  // namespace ddssec::pki
