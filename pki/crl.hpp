// Certificate revocation lists.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/crl_number.hpp"

namespace ddssec::pki {

/// The largest number of revocation lists in one file.
inline constexpr std::size_t kMaxCrlsInFile = 64;

/// The reason for a revocation (RFC 5280 5.3.1), with the numbers of CRLReason.
enum class RevocationReason : std::uint8_t {
  unspecified = 0,
  key_compromise = 1,
  ca_compromise = 2,
  affiliation_changed = 3,
  superseded = 4,
  cessation_of_operation = 5,
  certificate_hold = 6,
  privilege_withdrawn = 9,
};

/// Returns the name in RFC 5280, such as "keyCompromise".
std::string_view to_string(RevocationReason reason);
/// Parses exactly that name; empty for any other text.
std::optional<RevocationReason> revocation_reason_from(std::string_view word);

/// One entry of a revocation list.
struct Revocation {
  std::string serial;  ///< upper-case hexadecimal digits, as Certificate::serial
  WallTime time = {};
  RevocationReason reason = RevocationReason::unspecified;
  bool operator==(const Revocation&) const = default;
};

/// An immutable revocation list; copies share it. It has no effect until a ChainVerifier has
/// checked its signature.
class Crl {
 public:
  /// Reads all lists of a file: one DER list, or any number of PEM blocks among others
  /// (certificates in the same file are skipped). The result is empty for a PEM file without a
  /// list. The whole file is refused if it contains a delta list (RFC 5280 5.2.4), a list with an
  /// unknown critical extension, or a list with an entry that only a delta list may have. A
  /// complete list may name delta lists (freshestCRL); these are never fetched. Errors:
  /// crl_malformed, crl_too_large, crl_is_delta.
  static Result<std::vector<Crl>> all_from(BytesView octets);
  /// Reads delta lists as well, like products that leave the decision to OpenSSL. Use the result
  /// only to predict what they do: nothing may be granted by such a list. Errors: crl_malformed,
  /// crl_too_large.
  static Result<std::vector<Crl>> all_with_deltas_from(BytesView octets);

  /// Returns the issuer name, RFC 2253.
  const std::string& issuer() const;
  WallTime this_update() const;
  /// Returns the time by which a newer list must exist; empty if the list does not state it.
  std::optional<WallTime> next_update() const;
  /// Returns the number of this list; empty if it has none or a negative one.
  std::optional<CrlNumber> number() const;
  /// Returns all entries, in the list's order. An unknown reason counts as unspecified. Error:
  /// crl_malformed.
  Result<std::vector<Revocation>> revoked() const;
  /// Returns PEM text; empty if OpenSSL has no memory for it.
  std::string pem() const;

  /// True if the list covers only a part of the CA's certificates, or comes from one of several
  /// places (issuingDistributionPoint, RFC 5280 5.2.5). ddssec's plugins do not start with such a
  /// list.
  bool is_partial() const;

  /// True if this list may replace `former`: it has the same issuer and scope, and neither its
  /// number nor its thisUpdate is lower (RFC 5280 5.2.3, 5.2.5). Does not check the signature.
  bool is_not_older_than(const Crl& former) const;

  /// True if this list is not older than `former`. Also true if `former` is dated after `now` (the
  /// clock was ahead when it was made), and this list has a higher number and contains all entries
  /// of `former`. A wrong clock therefore never loses a revocation. Does not check the signature.
  bool may_replace_at(const Crl& former, WallTime now) const;

  /// Returns the identifier of the key that the list names as its signer (authorityKeyIdentifier),
  /// in hexadecimal digits; empty if it names none.
  std::string authority_key_id() const;

  /// True if both have the same issuer name and do not name different keys as signers.
  bool may_be_from_same_ca(const Crl& other) const;

  /// True if its issuer has the name of `ca`. The caller must still check that `ca` signed it.
  bool is_named_after(const Certificate& ca) const;

  /// True if `issuer` may sign lists and signed this one. May leave errors in OpenSSL's queue.
  bool is_signed_by(const Certificate& issuer) const;

  /// True if both are copies of one object, which was read from one file at one time.
  bool is_copy_of(const Crl& other) const { return impl_ == other.impl_; }

  /// Succeeds if `issuer` signed the list and may do so, and the list is valid at `now`. Errors:
  /// crl_signature_invalid, crl_not_yet_valid, crl_expired.
  Status check(const Certificate& issuer, WallTime now) const;

 private:
  friend struct PkiAccess;
  struct Impl;
  explicit Crl(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

  std::shared_ptr<const Impl> impl_;
};

/// True if one key of `cas` signed both lists, which proves that they are of one CA. The name alone
/// does not prove that.
bool have_common_signer(const Crl& a, const Crl& b, std::span<const Certificate> cas);

}  // namespace ddssec::pki
