#include "base/hash.hpp"

#include <cstdlib>
#include <memory>

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <sodium.h>

namespace ddssec {

namespace {

struct FreeContext {
  void operator()(EVP_MD_CTX* context) const noexcept { EVP_MD_CTX_free(context); }
};

// OpenSSL uses the CPU's SHA instructions. Returns false if OpenSSL fails, for example while the
// process is exiting.
bool sha256_by_openssl(std::initializer_list<BytesView> parts, std::span<std::uint8_t, 32> digest) {
  static const EVP_MD* const algorithm = EVP_MD_fetch(nullptr, "SHA256", nullptr);
  const std::unique_ptr<EVP_MD_CTX, FreeContext> context(EVP_MD_CTX_new());
  if (!algorithm || !context || EVP_DigestInit_ex(context.get(), algorithm, nullptr) != 1)
    return false;
  for (auto part : parts)
    if (EVP_DigestUpdate(context.get(), part.data(), part.size()) != 1) return false;
  return EVP_DigestFinal_ex(context.get(), digest.data(), nullptr) == 1;
}

void sha256_by_libsodium(std::initializer_list<BytesView> parts,
                         std::span<std::uint8_t, 32> digest) {
  crypto_hash_sha256_state state;
  crypto_hash_sha256_init(&state);
  for (auto part : parts) crypto_hash_sha256_update(&state, part.data(), part.size());
  crypto_hash_sha256_final(&state, digest.data());
  sodium_memzero(&state, sizeof state);
}

}  // namespace

Sha256Digest sha256(std::initializer_list<BytesView> parts) {
  Sha256Digest digest;
  sha256(parts, digest);
  return digest;
}

void sha256(std::initializer_list<BytesView> parts, std::span<std::uint8_t, 32> out) {
  if (!sha256_by_openssl(parts, out)) sha256_by_libsodium(parts, out);
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
  // EVP_Digest fails only if a FIPS provider refuses MD5. A KEY_HASH (RTPS 9.6.4.8) cannot be
  // computed then.
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
