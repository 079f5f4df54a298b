// Whether a certificate may be believed: up to the configured CA file, at a given time.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/crl.hpp"

namespace ddssec::pki {

/// What to do when the revocation list for a certificate's issuer is missing or out of date.
/// A revoked certificate and a forged list are refused under either.
enum class CrlPolicy : std::uint8_t { hard_fail, soft_fail };

/// Proof that a certificate chains to the configured CA file at a time. Only ChainVerifier makes
/// it.
class ChainValid {
 public:
  const Certificate& certificate() const { return certificate_; }
  /// The earliest not_after over the path: the proof ends here.
  WallTime not_after() const { return not_after_; }
  /// Subject of the certificate that ends first.
  const std::string& first_to_expire() const { return first_to_expire_; }
  /// The earliest nextUpdate among the configured revocation lists, if there are any.
  std::optional<WallTime> crl_next_update() const { return crl_next_update_; }

 private:
  friend class ChainVerifier;
  explicit ChainValid(Certificate certificate) : certificate_(std::move(certificate)) {}
  Certificate certificate_;
  WallTime not_before_{};
  WallTime not_after_{};
  std::string first_to_expire_;
  std::optional<WallTime> crl_next_update_;
};

/// Judges certificates against one CA file. Every certificate of that file is a trust anchor,
/// subordinate CAs without their root included; certificates that a peer sends along are not used.
/// Checked: signatures (SHA-1 only as an anchor's signature on itself), validity, basicConstraints,
/// path length, keyUsage, key sizes, name constraints, critical extensions, revocation.
/// Thread-safe. Remembers up to kMostRemembered positive verdicts with the time span in which they
/// hold, so that a certificate already judged costs a look-up.
class ChainVerifier {
 public:
  static constexpr std::size_t kMostRemembered = 1024;

  /// `crls` empty = no revocation check. Errors: not_a_ca if a certificate of the file is none;
  /// internal.
  static Result<ChainVerifier> make(std::vector<Certificate> anchors, std::vector<Crl> crls = {},
                                    CrlPolicy policy = CrlPolicy::hard_fail);

  /// Judges `certificate` at `now`. With revocation lists, the certificate's issuer must have one
  /// (hard_fail); CA certificates of the file are looked up where their issuer has one.
  /// Errors: certificate_expired, certificate_not_yet_valid, issuer_unknown,
  /// certificate_signature_invalid, certificate_revoked, crl_missing, crl_expired,
  /// crl_not_yet_valid, crl_signature_invalid, not_a_ca, path_too_long, key_usage_forbids,
  /// digest_too_weak, chain_refused (anything else, with OpenSSL's reason).
  Result<ChainValid> verify(const Certificate& certificate, WallTime now) const;

  /// False: no configured list names it or one of the CAs, so `verify` does not say
  /// certificate_revoked. Costs a look-up in each list.
  bool may_be_revoked(const Certificate& certificate) const;

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
