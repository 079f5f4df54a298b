// The c.* fields that requests and replies share: who speaks, with what permissions and algorithms.
#pragma once

#include <optional>

#include "base/hash.hpp"
#include "pki/key_agreement.hpp"
#include "plugins/authentication/token_fields.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// The longest c.perm, in octets. A peer is believed to need it before it has proven anything.
inline constexpr std::size_t kMostPermissionsOctets = 1024 * 1024;

/// As sent or received, borrowed. Algorithm names are known ones; everything else is a claim.
struct Credentials {
  BytesView id;                          ///< c.id: certificate, PEM
  std::optional<BytesView> permissions;  ///< c.perm: signed document, perhaps with one NUL more
  BytesView participant_data;            ///< c.pdata: big-endian parameter list
  BytesView signature_algorithm;         ///< c.dsign_algo
  BytesView key_agreement_algorithm;     ///< c.kagree_algo
  pki::KeyAgreementKind key_agreement;   ///< what c.kagree_algo names

  /// Errors: token_field_missing, token_field_repeated, token_field_length,
  /// signature_algorithm_unknown, key_agreement_algorithm_unknown.
  static Result<Credentials> read(const TokenFields& fields);
  void write(spi::Token& token) const;

  /// hash_c1 or hash_c2 (DDS-Security 9.3.2.5): the fields in the standard's order; c.perm counts
  /// only if it is there.
  Sha256Digest hash() const;
};

/// Appends a binary property.
void add_field(spi::Token& token, std::string_view name, BytesView value);

}  // namespace ddssec::authentication
