// Certificate revocation lists.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/crl_number.hpp"

namespace ddssec::pki {

/// The largest number of revocation lists in one file.
inline constexpr std::size_t kMostCrlsInFile = 64;

/// Why a certificate was revoked (RFC 5280 5.3.1), with the numbers of CRLReason.
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

/// RFC 5280's word, such as "keyCompromise".
std::string_view to_string(RevocationReason reason);
/// Exact; nothing for other words.
std::optional<RevocationReason> revocation_reason_from(std::string_view word);

/// One entry of a revocation list.
struct Revocation {
  std::string serial;  ///< upper-case hexadecimal digits, as Certificate::serial
  WallTime time = {};
  RevocationReason reason = RevocationReason::unspecified;
  bool operator==(const Revocation&) const = default;
};

/// An immutable revocation list; copies share it. It counts for nothing until a ChainVerifier has
/// checked who signed it.
class Crl {
 public:
  /// Every list of a file: one DER list, or any number of PEM blocks among others (certificates in
  /// the same file are passed over). The result is empty for a PEM file without a list. One delta
  /// list (RFC 5280 5.2.4) refuses the file, and so does a list with a critical extension that is
  /// not understood, or with an entry that only a delta list may have. A complete list may name
  /// delta lists (freshestCRL); nothing fetches them. Errors: crl_malformed, crl_too_large,
  /// crl_is_delta.
  static Result<std::vector<Crl>> all_from(BytesView octets);

  /// Issuer name, RFC 2253.
  const std::string& issuer() const;
  WallTime this_update() const;
  /// When a newer one must be there; nothing if the list does not say.
  std::optional<WallTime> next_update() const;
  /// The number of this list; nothing if the list does not say or the number is negative.
  std::optional<CrlNumber> number() const;
  /// Every entry, in the list's order; a reason that is not known counts as unspecified.
  /// Error: crl_malformed.
  Result<std::vector<Revocation>> revoked() const;
  /// PEM text.
  std::string pem() const;

  /// True if it says that it is about a part of the CA's certificates only, or comes from one of
  /// several places (issuingDistributionPoint, RFC 5280 5.2.5). ddssec's plugins do not start with
  /// such a list.
  bool is_partial() const;

  /// True if this list may take the place of `former`: of the same issuer, about the same
  /// certificates, and neither its number nor its thisUpdate is lower (RFC 5280 5.2.3, 5.2.5).
  /// Does not check the signature.
  bool supersedes(const Crl& former) const;

  /// True if it supersedes `former`; or if `former` is dated after `now`, because it was made under
  /// a clock that was ahead, and this list has a higher number and names all that `former` names.
  /// So no wrong clock makes it lose a revocation. Does not check the signature.
  bool replaces(const Crl& former, WallTime now) const;

  /// The key that the list says it is signed by (authorityKeyIdentifier), in hexadecimal digits;
  /// empty if it does not say.
  std::string authority_key_id() const;

  /// True if both bear one name and do not say that different keys signed them.
  bool seems_of_same_ca(const Crl& other) const;

  /// True if it bears the name of `ca`, which then is to be asked whether it signed it.
  bool is_named_after(const Certificate& ca) const;

  /// True if `issuer` may sign lists and signed this one. May leave reasons in OpenSSL's queue.
  bool is_signed_by(const Certificate& issuer) const;

  /// Success if `issuer` signed the list, may do so, and the list is of this time.
  /// Errors: crl_signature_invalid, crl_not_yet_valid, crl_expired.
  Status check(const Certificate& issuer, WallTime now) const;

  struct Impl;
  /// For pki/ only.
  const Impl& impl() const { return *impl_; }
  /// For pki/ only.
  explicit Crl(std::shared_ptr<const Impl> impl) : impl_(std::move(impl)) {}

 private:
  std::shared_ptr<const Impl> impl_;
};

/// True if one key of `cas` signed both lists: they are of one CA. The name alone does not say so.
bool have_common_signer(const Crl& a, const Crl& b, std::span<const Certificate> cas);

}  // namespace ddssec::pki
