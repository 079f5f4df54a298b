// What an identity trusts: its certificate authorities and revocation lists, with memory.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "base/hash.hpp"
#include "pki/certificate.hpp"
#include "pki/chain.hpp"

namespace ddssec::authentication {

/// Thread-safe. Remembers certificates that passed, so that one is parsed and judged once however
/// many handshakes present it.
class TrustStore {
 public:
  static constexpr std::size_t kMostRemembered = 1024;

  explicit TrustStore(pki::ChainVerifier verifier) : verifier_(std::move(verifier)) {}

  /// Parses a peer's c.id, or finds what was parsed before. Errors of Certificate::from_pem.
  Result<pki::Certificate> certificate(BytesView pem) const;

  /// Judges at `now`. Errors of ChainVerifier::verify.
  Result<pki::ChainValid> verify(const pki::Certificate& certificate, WallTime now) const {
    return verifier_.verify(certificate, now);
  }

  /// As ChainVerifier's.
  bool may_be_revoked(const pki::Certificate& certificate) const {
    return verifier_.may_be_revoked(certificate);
  }

  /// Call after `verify` said yes: nothing unproven takes up room.
  void remember(BytesView pem, const pki::Certificate& certificate) const;

  const std::vector<pki::Certificate>& anchors() const { return verifier_.anchors(); }

 private:
  struct DigestHash {
    std::size_t operator()(const Sha256Digest& digest) const;
  };

  pki::ChainVerifier verifier_;
  mutable std::mutex mutex_;
  mutable std::unordered_map<Sha256Digest, pki::Certificate, DigestHash> known_;
};

/// Gives identities with the same authorities and lists the same store, so that a process with many
/// participants judges each peer once. Thread-safe; forgets stores that are not used any more.
class TrustStores {
 public:
  explicit TrustStores(pki::CrlPolicy policy) : policy_(policy) {}

  /// Errors of ChainVerifier::make.
  Result<std::shared_ptr<const TrustStore>> open(std::vector<pki::Certificate> anchors,
                                                 std::vector<pki::Crl> crls);

 private:
  const pki::CrlPolicy policy_;
  std::mutex mutex_;
  std::map<Sha256Digest, std::weak_ptr<const TrustStore>> stores_;
};

}  // namespace ddssec::authentication
