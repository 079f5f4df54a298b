// The documents that an identity trusts: its certificate authorities and revocation lists, with a
// cache of certificates.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "base/hash.hpp"
#include "pki/certificate.hpp"
#include "pki/chain.hpp"
#include "pki/ocsp.hpp"

namespace ddssec::authentication {

/// Verifies peers' certificates. Remembers certificates that passed, so that each is parsed and
/// verified once, however many handshakes present it. Thread-safe.
class TrustStore {
 public:
  static constexpr std::size_t kMaxRemembered = 1024;

  explicit TrustStore(pki::ChainVerifier verifier) : verifier_(std::move(verifier)) {}

  /// Parses a peer's c.id, or returns the remembered certificate. Errors: those of
  /// Certificate::from_pem.
  Result<pki::Certificate> certificate(BytesView pem) const;

  /// Verifies the certificate at `now`. Errors: those of ChainVerifier::verify.
  Result<pki::ValidChain> verify(const pki::Certificate& certificate, WallTime now) const {
    return verifier_.verify(certificate, now);
  }

  /// See ChainVerifier::is_on_any_list.
  bool is_on_any_list(const pki::Certificate& certificate) const {
    return verifier_.is_on_any_list(certificate);
  }

  /// Judges a peer's OCSP response, or returns the former result: the same response costs only one
  /// lookup. Errors: those of pki::judge_ocsp.
  Result<pki::GoodOcspStatus> ocsp(BytesView response, const pki::Certificate& certificate,
                                   WallTime now) const;

  /// Remembers a certificate. Call it only after `verify` succeeded, so that unproven certificates
  /// take no memory.
  void remember(BytesView pem, const pki::Certificate& certificate) const;

  const std::vector<pki::Certificate>& anchors() const { return verifier_.anchors(); }

 private:
  struct DigestHash {
    std::size_t operator()(const Sha256Digest& digest) const;
  };

  pki::ChainVerifier verifier_;
  mutable std::mutex mutex_;
  mutable std::unordered_map<Sha256Digest, pki::Certificate, DigestHash> known_;
  mutable std::unordered_map<Sha256Digest, pki::GoodOcspStatus, DigestHash> known_ocsp_;
};

/// Shares stores: identities with the same authorities and lists get the same store, so that a
/// process with many participants verifies each peer once. Stores that are no longer used are
/// dropped. Thread-safe.
class TrustStores {
 public:
  explicit TrustStores(pki::CrlPolicy policy) : policy_(policy) {}

  /// Returns the store for these authorities and lists. Errors: those of ChainVerifier::make.
  Result<std::shared_ptr<const TrustStore>> open(std::vector<pki::Certificate> anchors,
                                                 std::vector<pki::Crl> crls);

 private:
  const pki::CrlPolicy policy_;
  std::mutex mutex_;
  std::map<Sha256Digest, std::weak_ptr<const TrustStore>> stores_;
};

}  // namespace ddssec::authentication
