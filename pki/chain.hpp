// Verifies certificates up to the configured CA file, at a given time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/crl.hpp"

namespace ddssec::pki {

/// The reaction to a missing or outdated revocation list of a certificate's issuer. A revoked
/// certificate and a forged list are refused with either policy.
enum class CrlPolicy : std::uint8_t { hard_fail, soft_fail };

/// Proof that a certificate chains to the configured CA file at a given time. Only ChainVerifier
/// creates one.
class ValidChain {
 public:
  const Certificate& certificate() const { return certificate_; }
  /// Returns the earliest not_after on the path. The proof is valid until then.
  WallTime not_after() const { return not_after_; }
  /// Returns the subject of the certificate that expires first.
  const std::string& first_to_expire() const { return first_to_expire_; }
  /// Returns the earliest nextUpdate among the configured revocation lists, if there are any.
  std::optional<WallTime> crl_next_update() const { return crl_next_update_; }

 private:
  friend class ChainVerifier;
  explicit ValidChain(Certificate certificate) : certificate_(std::move(certificate)) {}
  Certificate certificate_;
  WallTime not_before_{};
  WallTime not_after_{};
  std::string first_to_expire_;
  std::optional<WallTime> crl_next_update_;
};

/// Verifies certificates against one CA file. Every certificate of that file is a trust anchor,
/// including subordinate CAs without their root. Certificates that a peer sends along are not used.
///
/// It checks signatures (SHA-1 only for an anchor's signature on itself), validity,
/// basicConstraints, path length, keyUsage, key sizes, name constraints, critical extensions and
/// revocation.
///
/// Thread-safe. Remembers up to kMaxRemembered positive results with their validity period, so
/// that a certificate already verified costs one lookup.
class ChainVerifier {
 public:
  static constexpr std::size_t kMaxRemembered = 1024;

  /// Creates a verifier. If `crls` is empty, revocation is not checked. Errors: not_a_ca if a
  /// certificate of the file is not a CA; internal.
  static Result<ChainVerifier> make(std::vector<Certificate> anchors, std::vector<Crl> crls = {},
                                    CrlPolicy policy = CrlPolicy::hard_fail);

  /// Verifies `certificate` at `now`. With revocation lists and hard_fail, there must be a list of
  /// the certificate's issuer. A CA certificate of the file is looked up only if there is a list of
  /// its issuer. Errors: certificate_expired, certificate_not_yet_valid, issuer_unknown,
  /// certificate_signature_invalid, certificate_revoked, crl_missing, crl_expired,
  /// crl_not_yet_valid, crl_signature_invalid, not_a_ca, path_too_long, key_usage_forbids,
  /// digest_too_weak, chain_refused (anything else, with OpenSSL's reason).
  Result<ValidChain> verify(const Certificate& certificate, WallTime now) const;

  /// True if a configured list names the certificate or one of the CAs. If not, `verify` does not
  /// fail with certificate_revoked. Costs one lookup in each list.
  bool is_on_any_list(const Certificate& certificate) const;

  /// Returns the certificates of the CA file, in its order. Valid as long as this object.
  const std::vector<Certificate>& anchors() const;

  ~ChainVerifier();
  ChainVerifier(ChainVerifier&&) noexcept;
  ChainVerifier& operator=(ChainVerifier&&) noexcept;

 private:
  struct Impl;
  explicit ChainVerifier(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace ddssec::pki
