// Tokens and properties: the data that the three plugins, and the two sides of a connection,
// exchange.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/property.hpp"
#include "base/reader.hpp"
#include "base/result.hpp"
#include "base/writer.hpp"

namespace ddssec::spi {

using ddssec::find_property;
using ddssec::Property;
using ddssec::property_value;
using ddssec::PropertyList;

/// BinaryProperty_t (DDS-Security 1.2, clause 7.3.3).
struct BinaryProperty {
  std::string name;
  Bytes value;
  bool propagate = true;
  bool operator==(const BinaryProperty&) const = default;
  /// Wipes the value, which is key material in a crypto token. (There is no move: copies wipe
  /// themselves too.)
  ~BinaryProperty();
};

/// DataHolder (DDS-Security 1.2, clause 7.3.4); every token of the standard has this type.
struct Token {
  std::string class_id = {};
  PropertyList properties = {};
  std::vector<BinaryProperty> binary_properties = {};
  bool operator==(const Token&) const = default;
};

/// Returns the value of the first binary property with that name, or nullptr. It is owned by
/// `token`.
const Bytes* find_binary_property(const Token& token, std::string_view name);
/// Returns the octets of the values of all binary properties together.
std::size_t binary_octets(const Token& token);

/// Limits for tokens that a peer sends. A larger number is refused before anything is allocated.
inline constexpr std::size_t kMaxPropertiesPerToken = 64;
inline constexpr std::size_t kMaxTokensPerMessage = 64;

/// Appends a token in XCDR1 in the writer's byte order. Leaves out properties that do not
/// propagate.
void write_token(Writer& writer, const Token& token);
/// Reads one token with at most kMaxPropertiesPerToken properties of each kind. Errors: truncated,
/// malformed, length_out_of_range.
Result<Token> read_token(Reader& reader);

/// A name and its value, borrowed, so that certificates and documents are not copied for hashing.
struct NamedOctets {
  std::string_view name;
  BytesView value;
};
/// Returns BinaryPropertySeq in big-endian XCDR1 without encapsulation: the input of hash_c1,
/// hash_c2 and of the handshake's signatures (DDS-Security 1.2, clause 10.3.2.5.1).
Bytes serialize_binary_properties(std::span<const NamedOctets> properties);

}  // namespace ddssec::spi
