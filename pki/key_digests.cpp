#include "pki/key_digests.hpp"

#include <algorithm>
#include <memory>
#include <string>

#include <openssl/core_names.h>
#include <openssl/err.h>

#include "base/hash.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

using PublicKeyPtr = std::unique_ptr<X509_PUBKEY, Deleter<X509_PUBKEY_free>>;

std::string digest_of(const unsigned char* der, int size) {
  return size > 0 ? to_hex(sha256(BytesView(der, static_cast<std::size_t>(size)))) : std::string();
}

std::string digest_of(const X509_PUBKEY* key) {
  unsigned char* der = nullptr;
  const int size = i2d_X509_PUBKEY(key, &der);
  const OpensslMemoryPtr owner(der);
  return digest_of(der, size);
}

// Returns the digest of the key as OpenSSL encodes it. An RSA key is encoded from its numbers,
// whatever the certificate says.
std::string encoded_digest(const EVP_PKEY* key) {
  unsigned char* der = nullptr;
  const int size = i2d_PUBKEY(key, &der);
  const OpensslMemoryPtr owner(der);
  return digest_of(der, size);
}

std::string point_digest(int curve, BytesView point) {
  const PublicKeyPtr key(X509_PUBKEY_new());
  OpensslMemoryPtr octets(static_cast<unsigned char*>(OPENSSL_memdup(point.data(), point.size())));
  if (!key || !octets ||
      X509_PUBKEY_set0_param(key.get(), OBJ_nid2obj(NID_X9_62_id_ecPublicKey), V_ASN1_OBJECT,
                             OBJ_nid2obj(curve), octets.get(), static_cast<int>(point.size())) != 1)
    return {};
  static_cast<void>(octets.release());  // the key owns it now
  return digest_of(key.get());
}

// Returns a coordinate of the point, or nothing if it cannot be read.
Bytes coordinate(const EVP_PKEY* key, const char* name, std::size_t size) {
  BIGNUM* read = nullptr;
  const bool is_read = EVP_PKEY_get_bn_param(key, name, &read) == 1;
  const BignumPtr number(read);
  Bytes out(size);
  const bool fits = is_read && BN_bn2binpad(number.get(), out.data(), static_cast<int>(size)) >= 0;
  return fits ? out : Bytes();
}

// Returns the digests of the uncompressed point and of the compressed one (SEC 1, 2.3.3).
std::vector<std::string> point_digests(const EVP_PKEY* key, int curve, std::size_t size) {
  const auto x = coordinate(key, OSSL_PKEY_PARAM_EC_PUB_X, size);
  const auto y = coordinate(key, OSSL_PKEY_PARAM_EC_PUB_Y, size);
  if (x.empty() || y.empty()) return {};
  Bytes uncompressed{0x04};
  uncompressed.insert(uncompressed.end(), x.begin(), x.end());
  uncompressed.insert(uncompressed.end(), y.begin(), y.end());
  Bytes compressed{static_cast<std::uint8_t>(0x02 | (y.back() & 1))};
  compressed.insert(compressed.end(), x.begin(), x.end());
  return {point_digest(curve, uncompressed), point_digest(curve, compressed)};
}

std::vector<std::string> encodings(const EVP_PKEY* key, KeyKind kind) {
  constexpr std::size_t kOctets256 = 32, kOctets384 = 48;
  switch (kind) {
    case KeyKind::ec_p256:
      return point_digests(key, NID_X9_62_prime256v1, kOctets256);
    case KeyKind::ec_p384:
      return point_digests(key, NID_secp384r1, kOctets384);
    case KeyKind::rsa:
      break;
  }
  return {encoded_digest(key)};
}

}  // namespace

KeyDigests::KeyDigests(const Certificate& certificate) {
  X509* x509 = impl_of(certificate).x509.get();
  all_ = encodings(X509_get0_pubkey(x509), certificate.key_algorithm().kind);
  ERR_clear_error();
  // The encoding in the certificate may differ from all of these, for example RSA without the NULL
  // parameters.
  all_.push_back(digest_of(X509_get_X509_PUBKEY(x509)));
}

bool KeyDigests::contains(std::string_view digest) const {
  return !digest.empty() && std::ranges::find(all_, digest) != all_.end();
}

std::string key_digest(const Certificate& certificate) {
  return KeyDigests(certificate).canonical();
}

}  // namespace ddssec::pki
