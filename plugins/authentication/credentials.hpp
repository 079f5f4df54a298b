// The c.* fields that requests and replies share: certificate, permissions, participant data and
// algorithms of the sender.
#pragma once

#include <optional>

#include "base/hash.hpp"
#include "pki/certificate_source.hpp"
#include "pki/key_agreement.hpp"
#include "plugins/authentication/token_fields.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::authentication {

/// The longest c.perm, in octets. It bounds memory for a peer that has not proven anything yet.
inline constexpr std::size_t kMaxPermissionsOctets = 1024 * 1024;

inline constexpr FieldRule kCertificate{"c.id", 1, pki::kMaxCertificateOctets};
inline constexpr FieldRule kPermissions{"c.perm", 0, kMaxPermissionsOctets};

/// The fields as sent or received, borrowed. Algorithm names were checked to be known ones; all
/// other fields are unproven.
struct Credentials {
  BytesView id;  ///< c.id: certificate, PEM
  /// c.perm: signed document, with or without a trailing NUL.
  std::optional<BytesView> permissions;
  BytesView participant_data;           ///< c.pdata: big-endian parameter list
  BytesView signature_algorithm;        ///< c.dsign_algo
  BytesView key_agreement_algorithm;    ///< c.kagree_algo
  pki::KeyAgreementKind key_agreement;  ///< the key agreement of that name
  /// ocsp_status, as received: the OCSP response about c.id (DER). It is not in the hash and
  /// therefore not signed. `write` does not write it.
  std::optional<BytesView> ocsp_status = {};

  /// Reads and checks the fields. Errors: token_field_missing, token_field_repeated,
  /// token_field_length, signature_algorithm_unknown, key_agreement_algorithm_unknown.
  static Result<Credentials> read(const TokenFields& fields);
  /// Appends the fields to `token`.
  void write(spi::Token& token) const;

  /// Returns hash_c1 or hash_c2 (DDS-Security 1.2, clause 10.3.2.5): SHA-256 over the fields in the
  /// standard's order; c.perm is included only if present.
  Sha256Digest hash() const;
};

/// Appends a binary property.
void add_field(spi::Token& token, std::string_view name, BytesView value);

}  // namespace ddssec::authentication
