// The public-key operations that participants cannot avoid, in OpenSSL with P-256.
#pragma once

#include <string>

#include <openssl/ec.h>

#include "pki/openssl.hpp"

namespace ddssec::bench {

using DigestContext = std::unique_ptr<EVP_MD_CTX, Deleter<EVP_MD_CTX_free>>;

inline const std::string kSigned(1024, 'x');

/// Returns the signature; empty if it failed.
inline Bytes sign(EVP_PKEY* key) {
  const DigestContext context(EVP_MD_CTX_new());
  Bytes signature(128);
  std::size_t size = signature.size();
  const bool made = context &&
                    EVP_DigestSignInit(context.get(), nullptr, EVP_sha256(), nullptr, key) == 1 &&
                    EVP_DigestSign(context.get(), signature.data(), &size, as_bytes(kSigned).data(),
                                   kSigned.size()) == 1;
  signature.resize(made ? size : 0);
  return signature;
}

inline bool verify(EVP_PKEY* key, BytesView signature) {
  const DigestContext context(EVP_MD_CTX_new());
  return context && EVP_DigestVerifyInit(context.get(), nullptr, EVP_sha256(), nullptr, key) == 1 &&
         EVP_DigestVerify(context.get(), signature.data(), signature.size(),
                          as_bytes(kSigned).data(), kSigned.size()) == 1;
}

inline bool derive(EVP_PKEY* own, EVP_PKEY* peer) {
  const pki::PkeyContextPtr context(EVP_PKEY_CTX_new(own, nullptr));
  unsigned char secret[32];
  std::size_t size = sizeof secret;
  return context && EVP_PKEY_derive_init(context.get()) == 1 &&
         EVP_PKEY_derive_set_peer(context.get(), peer) == 1 &&
         EVP_PKEY_derive(context.get(), secret, &size) == 1;
}

/// Does one side's part of a handshake. `signatures` to verify are two, on the peer's certificate
/// and on its message, or three with its permissions.
inline bool half_a_handshake(EVP_PKEY* key, int signatures) {
  const pki::PkeyPtr own(EVP_EC_gen("P-256"));
  const auto signature = sign(key);
  for (int i = 0; i < signatures; ++i)
    if (!verify(key, signature)) return false;
  return own && derive(own.get(), key);
}

}  // namespace ddssec::bench
