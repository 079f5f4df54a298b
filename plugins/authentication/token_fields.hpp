// Strict access to the binary properties of a token that a peer sent.
#pragma once

#include <optional>
#include <string_view>

#include "base/hash.hpp"
#include "plugins/spi/shared_secret.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// The kinds of token, by the text after "DDS:Auth:PKI-DH:1.x" in the class id.
enum class TokenClass : std::uint8_t {
  identity,
  auth_request,
  request,
  reply,
  final,
  // Specific to ddssec, between two of its participants:
  renewal,
  renewal_accepted,
};

/// Returns the class id to send, such as "DDS:Auth:PKI-DH:1.0+Req".
std::string_view class_id_of(TokenClass token_class);

/// Returns the kind of token; empty for an unknown class id. Plugin name and major version must be
/// those of this plugin, and the suffix a known one. The minor version does not matter
/// (DDS-Security 1.2, clause 10.3.2.1).
std::optional<TokenClass> token_class_of(std::string_view class_id);

/// Returns the kind according to the end of the class id alone, whatever is before it. It is the
/// kind that a token of another plugin or version is meant to be. Empty for an unknown end.
std::optional<TokenClass> claimed_class_of(std::string_view class_id);

/// The longest class id, property name or text property, in octets.
inline constexpr std::size_t kMaxTextOctets = 4096;
/// The longest binary property with an unknown name, in octets.
inline constexpr std::size_t kMaxUnknownOctets = 64 * 1024;

/// A field's name and its allowed length in octets.
struct FieldRule {
  std::string_view name;
  std::size_t min;
  std::size_t max;
};

/// Checked access to a token of a known class. Everything is borrowed from the token.
class TokenFields {
 public:
  /// Gives access to `token`, which must outlive the returned object. Errors: token_class_wrong,
  /// token_too_large (too many properties, or an unknown or text property is too long).
  static Result<TokenFields> of(const spi::Token& token, TokenClass expected);

  /// Returns a field that must be present. Errors: token_field_missing, token_field_repeated,
  /// token_field_length.
  Result<BytesView> required(const FieldRule& rule) const;
  /// Returns a field that may be absent. Errors: token_field_repeated, token_field_length.
  Result<std::optional<BytesView>> optional(const FieldRule& rule) const;
  /// Returns a required field of exactly 32 octets. Errors as of `required`.
  Result<spi::Challenge> challenge(std::string_view name) const;
  /// Returns an optional field of exactly 32 octets. Errors as of `optional`.
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
inline constexpr std::string_view kParticipantDataName = "c.pdata";
inline constexpr std::string_view kChallenge1 = "challenge1";
inline constexpr std::string_view kChallenge2 = "challenge2";
inline constexpr std::string_view kHashC1 = "hash_c1";
inline constexpr std::string_view kHashC2 = "hash_c2";
inline constexpr std::string_view kFutureChallenge = "future_challenge";

/// Returns the name of the token as the document of an error, such as "handshake request".
std::string_view document_name(TokenClass token_class);

/// Success if an optional field is absent or equals `known`. Error: token_field_differs.
Status check_repeated(std::string_view name, const std::optional<BytesView>& received,
                      BytesView known, TokenClass token_class);

}  // namespace ddssec::authentication
