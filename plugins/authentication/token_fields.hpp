// Strict access to the binary properties of a token that a peer sent.
#pragma once

#include <optional>
#include <string_view>

#include "base/hash.hpp"
#include "plugins/spi/shared_secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// What may stand behind "DDS:Auth:PKI-DH:1.x" in a class id.
enum class TokenClass : std::uint8_t { identity, auth_request, request, reply, final };

/// "DDS:Auth:PKI-DH:1.0+Req" and so on: what we send.
std::string_view class_id_of(TokenClass token_class);

/// Plugin name and major version must be ours, the suffix one that we know; the minor version does
/// not matter (DDS-Security 9.3.2.1). Nothing if the token is of no such class.
std::optional<TokenClass> token_class_of(std::string_view class_id);

/// The longest class id, property name or text property.
inline constexpr std::size_t kMostTextOctets = 4096;
/// The longest binary property whose name we do not know.
inline constexpr std::size_t kMostUnknownOctets = 64 * 1024;

/// A field's name with the number of octets that it may have.
struct FieldRule {
  std::string_view name;
  std::size_t least;
  std::size_t most;
};

/// Checked access to a token of a known class. Everything is borrowed from the token.
class TokenFields {
 public:
  /// Errors: token_class_wrong, token_too_large (too many properties, or an unknown or text
  /// property too long).
  static Result<TokenFields> of(const spi::Token& token, TokenClass expected);

  /// Errors: token_field_missing, token_field_repeated, token_field_length.
  Result<BytesView> required(const FieldRule& rule) const;
  /// Errors: token_field_repeated, token_field_length.
  Result<std::optional<BytesView>> optional(const FieldRule& rule) const;
  /// Exactly 32 octets.
  Result<spi::Challenge> challenge(std::string_view name) const;
  /// Exactly 32 octets, if there.
  Result<std::optional<Sha256Digest>> optional_hash(std::string_view name) const;

 private:
  TokenFields(const spi::Token& token, TokenClass token_class)
      : token_(&token), class_(token_class) {}

  const spi::Token* token_;
  TokenClass class_;
};

/// The longest key agreement public key, in octets.
inline constexpr FieldRule kDh1{"dh1", 1, 1024};
inline constexpr FieldRule kDh2{"dh2", 1, 1024};
inline constexpr FieldRule kSignature{"signature", 1, 2048};
inline constexpr std::string_view kChallenge1 = "challenge1";
inline constexpr std::string_view kChallenge2 = "challenge2";
inline constexpr std::string_view kHashC1 = "hash_c1";
inline constexpr std::string_view kHashC2 = "hash_c2";
inline constexpr std::string_view kFutureChallenge = "future_challenge";

/// The token as an error's document: "handshake request" and so on.
std::string_view document_name(TokenClass token_class);

/// Fails with token_field_differs unless a field that may be left out is what we know it to be.
Status check_repeated(std::string_view name, const std::optional<BytesView>& received,
                      BytesView known, TokenClass token_class);

}  // namespace ddssec::authentication
