#include "plugins/authentication/trust_store.hpp"

namespace ddssec::authentication {
namespace {

Sha256Digest digest_of(const std::vector<pki::Certificate>& anchors,
                       const std::vector<pki::Crl>& crls) {
  Bytes octets;
  const auto append = [&](BytesView part) {
    octets.insert(octets.end(), part.begin(), part.end());
  };
  for (const auto& anchor : anchors) append(anchor.fingerprint());
  for (const auto& crl : crls) append(sha256(as_bytes(crl.pem())));
  octets.push_back(static_cast<std::uint8_t>(anchors.size()));  // where the lists begin
  return sha256(octets);
}

}  // namespace

std::size_t TrustStore::DigestHash::operator()(const Sha256Digest& digest) const {
  std::size_t value = 0;
  for (std::size_t i = 0; i < sizeof value; ++i) value = (value << 8) | digest[i];
  return value;
}

Result<pki::Certificate> TrustStore::certificate(BytesView pem) const {
  {
    const Sha256Digest digest = sha256(pem);
    const std::scoped_lock lock(mutex_);
    if (const auto known = known_.find(digest); known != known_.end()) return known->second;
  }
  return pki::Certificate::from_pem(pem);
}

void TrustStore::remember(BytesView pem, const pki::Certificate& certificate) const {
  const Sha256Digest digest = sha256(pem);
  const std::scoped_lock lock(mutex_);
  // Dropping all entries at once is rare and costs one parse for each. Tracking their age would
  // cost time on every use.
  if (known_.size() >= kMaxRemembered) known_.clear();
  known_.try_emplace(digest, certificate);
}

// Only good responses are remembered. A trusted responder has signed these, so an attacker cannot
// fill the memory.
Result<pki::GoodOcspStatus> TrustStore::ocsp(BytesView response,
                                             const pki::Certificate& certificate,
                                             WallTime now) const {
  Bytes octets = to_bytes(certificate.fingerprint());
  octets.insert(octets.end(), response.begin(), response.end());
  const Sha256Digest digest = sha256(octets);
  {
    const std::scoped_lock lock(mutex_);
    const auto known = known_ocsp_.find(digest);
    if (known != known_ocsp_.end() && known->second.holds_at(now)) return known->second;
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto good, pki::judge_ocsp(response, certificate, verifier_, now));
  const std::scoped_lock lock(mutex_);
  if (known_ocsp_.size() >= kMaxRemembered) known_ocsp_.clear();
  known_ocsp_.insert_or_assign(digest, good);
  return good;
}

Result<std::shared_ptr<const TrustStore>> TrustStores::open(std::vector<pki::Certificate> anchors,
                                                            std::vector<pki::Crl> crls) {
  const Sha256Digest digest = digest_of(anchors, crls);
  const std::scoped_lock lock(mutex_);
  std::erase_if(stores_, [](const auto& entry) { return entry.second.expired(); });
  if (const auto known = stores_.find(digest); known != stores_.end())
    if (auto store = known->second.lock()) return store;
  DDSSEC_ASSIGN_OR_RETURN(auto verifier,
                          pki::ChainVerifier::make(std::move(anchors), std::move(crls), policy_));
  auto store = std::make_shared<const TrustStore>(std::move(verifier));
  stores_[digest] = store;
  return store;
}

}  // namespace ddssec::authentication
