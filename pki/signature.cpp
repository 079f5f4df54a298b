#include "pki/signature.hpp"

#include <array>

#include <openssl/rsa.h>

#include "base/never_destroyed.hpp"
#include "pki/certificate_context.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

constexpr int kSaltOctets = 32;

// The digests are fetched once, because a fetch by name for every signature costs about a
// microsecond.
const EVP_MD* digest_for(KeyKind kind) {
  static const NeverDestroyed<DigestPtr> sha256_digest(EVP_MD_fetch(nullptr, "SHA256", nullptr));
  static const NeverDestroyed<DigestPtr> sha384_digest(EVP_MD_fetch(nullptr, "SHA384", nullptr));
  return (kind == KeyKind::ec_p384 ? *sha384_digest : *sha256_digest).get();
}

struct Digest {
  std::array<std::uint8_t, EVP_MAX_MD_SIZE> octets;
  unsigned size = 0;
};

bool hash(const EVP_MD* md, BytesView message, Digest& out) {
  return EVP_Digest(message.data(), message.size(), out.octets.data(), &out.size, md, nullptr) == 1;
}

bool set_up(EVP_PKEY_CTX* context, KeyKind kind, int salt) {
  const EVP_MD* md = digest_for(kind);
  if (EVP_PKEY_CTX_set_signature_md(context, md) != 1) return false;
  if (kind != KeyKind::rsa) return true;
  return EVP_PKEY_CTX_set_rsa_padding(context, RSA_PKCS1_PSS_PADDING) == 1 &&
         EVP_PKEY_CTX_set_rsa_mgf1_md(context, md) == 1 &&
         EVP_PKEY_CTX_set_rsa_pss_saltlen(context, salt) == 1;
}

}  // namespace

Result<Bytes> sign(const PrivateKey& key, BytesView message) {
  EVP_PKEY* pkey = impl_of(key).pkey.get();
  const KeyKind kind = key.algorithm().kind;
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_pkey(nullptr, pkey, nullptr));
  Digest digest;
  if (!context || !hash(digest_for(kind), message, digest) ||
      EVP_PKEY_sign_init(context.get()) != 1 || !set_up(context.get(), kind, kSaltOctets))
    return openssl_error(Code::internal);
  std::size_t size = static_cast<std::size_t>(EVP_PKEY_get_size(pkey));
  Bytes signature(size);
  // If memory runs out while ECDSA writes, OpenSSL 3.0 reports success with 2^32 - 1 octets.
  if (EVP_PKEY_sign(context.get(), signature.data(), &size, digest.octets.data(), digest.size) !=
          1 ||
      size > signature.size())
    return openssl_error(Code::internal);
  signature.resize(size);
  return signature;
}

Result<ValidSignature> verify(const Certificate& signer, BytesView message, BytesView signature) {
  EVP_PKEY* pkey = X509_get0_pubkey(impl_of(signer).x509.get());
  const KeyKind kind = signer.key_algorithm().kind;
  if (signature.size() > kMaxSignatureOctets)
    return fail(Code::signature_invalid, {.note = "it is too long"});
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_pkey(certificate_context(), pkey, nullptr));
  Digest digest;
  if (!context || !hash(digest_for(kind), message, digest) ||
      EVP_PKEY_verify_init(context.get()) != 1 ||
      !set_up(context.get(), kind, RSA_PSS_SALTLEN_AUTO))
    return openssl_error(Code::internal);
  // Negative results are failures too: only 1 is success.
  if (EVP_PKEY_verify(context.get(), signature.data(), signature.size(), digest.octets.data(),
                      digest.size) != 1)
    return openssl_error(Code::signature_invalid, {.field = "signer " + signer.subject()});
  return ValidSignature(signer);
}

}  // namespace ddssec::pki
