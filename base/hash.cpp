#include "base/hash.hpp"

#include <cstdlib>

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <sodium.h>

namespace ddssec {

Sha256Digest sha256(std::initializer_list<BytesView> parts) {
  crypto_hash_sha256_state state;
  crypto_hash_sha256_init(&state);
  for (auto part : parts) crypto_hash_sha256_update(&state, part.data(), part.size());
  Sha256Digest digest;
  crypto_hash_sha256_final(&state, digest.data());
  return digest;
}

Sha256Digest hmac_sha256(BytesView key, std::initializer_list<BytesView> parts) {
  crypto_auth_hmacsha256_state state;
  crypto_auth_hmacsha256_init(&state, key.data(), key.size());
  for (auto part : parts) crypto_auth_hmacsha256_update(&state, part.data(), part.size());
  Sha256Digest digest;
  crypto_auth_hmacsha256_final(&state, digest.data());
  sodium_memzero(&state, sizeof state);
  return digest;
}

Md5Digest md5(BytesView octets) {
  Md5Digest digest;
  // Only fails where a FIPS provider refuses MD5; KEY_HASH then cannot be had at all.
  if (EVP_Digest(octets.data(), octets.size(), digest.data(), nullptr, EVP_md5(), nullptr) != 1)
    std::abort();
  return digest;
}

void wipe(MutableBytes octets) noexcept { sodium_memzero(octets.data(), octets.size()); }

bool constant_time_equal(BytesView a, BytesView b) noexcept {
  // sodium_memcmp takes six times as long over the 16 octets of a tag.
  return a.size() == b.size() && CRYPTO_memcmp(a.data(), b.data(), a.size()) == 0;
}

}  // namespace ddssec
