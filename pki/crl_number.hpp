// Numbers of revocation lists.
#pragma once

#include <compare>
#include <cstdint>
#include <optional>
#include <string>

#include "base/bytes.hpp"

namespace ddssec::pki {

/// The number of a revocation list. It is not negative, and has up to 20 octets in lists of CAs
/// that follow RFC 5280 5.2.3. Longer ones are compared in the same way.
class CrlNumber {
 public:
  CrlNumber(std::uint64_t number = 0);  // NOLINT: a number is a number
  /// Most significant octet first.
  static CrlNumber from_octets(BytesView octets);

  /// Without leading zeros; empty for 0.
  BytesView octets() const { return octets_; }
  /// The value; empty if it has more than 64 bits.
  std::optional<std::uint64_t> as_uint64() const;
  CrlNumber next() const;

  friend bool operator==(const CrlNumber&, const CrlNumber&) = default;
  friend std::strong_ordering operator<=>(const CrlNumber& a, const CrlNumber& b);

 private:
  Bytes octets_;
};

/// Decimal digits; for a number that is longer than RFC 5280 allows, only its length.
std::string to_string(const CrlNumber& number);

}  // namespace ddssec::pki
