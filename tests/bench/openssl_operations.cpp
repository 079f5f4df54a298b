// What a participant costs OpenSSL at least. "bare": a key and two signatures, on its certificate
// and on its permissions. "forms": the same as the files that participants have: X.509, PKCS#8 and
// S/MIME. "handshake": what the two sides of one handshake do with keys; the message, the
// certificate and the permissions are signed octets. Prints the processor seconds of COUNT of each.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include <openssl/cms.h>
#include <openssl/ec.h>
#include <openssl/pem.h>

#include "pki/openssl.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::pki;
using DigestContext = std::unique_ptr<EVP_MD_CTX, Deleter<EVP_MD_CTX_free>>;

const std::string kSigned(1024, 'x');

/// A CA and what stands for its certificate.
struct Ca {
  PkeyPtr key;
  X509Ptr certificate;
};

/// Empty: it failed.
Bytes sign(EVP_PKEY* key) {
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

bool verify(EVP_PKEY* key, BytesView signature) {
  const DigestContext context(EVP_MD_CTX_new());
  return context && EVP_DigestVerifyInit(context.get(), nullptr, EVP_sha256(), nullptr, key) == 1 &&
         EVP_DigestVerify(context.get(), signature.data(), signature.size(),
                          as_bytes(kSigned).data(), kSigned.size()) == 1;
}

bool derive(EVP_PKEY* own, EVP_PKEY* peer) {
  const std::unique_ptr<EVP_PKEY_CTX, Deleter<EVP_PKEY_CTX_free>> context(
      EVP_PKEY_CTX_new(own, nullptr));
  unsigned char secret[32];
  std::size_t size = sizeof secret;
  return context && EVP_PKEY_derive_init(context.get()) == 1 &&
         EVP_PKEY_derive_set_peer(context.get(), peer) == 1 &&
         EVP_PKEY_derive(context.get(), secret, &size) == 1;
}

bool bare(const Ca& ca) {
  const PkeyPtr own(EVP_EC_gen("P-256"));
  return own && !sign(ca.key.get()).empty() && !sign(ca.key.get()).empty();
}

/// One side's part: the peer's message, certificate and permissions each bear a signature.
bool half_a_handshake(const Ca& ca) {
  constexpr int kVerified = 3;
  const PkeyPtr own(EVP_EC_gen("P-256"));
  const auto signature = sign(ca.key.get());
  for (int i = 0; i < kVerified; ++i)
    if (!verify(ca.key.get(), signature)) return false;
  return own && derive(own.get(), ca.key.get());
}

bool handshake(const Ca& ca) { return half_a_handshake(ca) && half_a_handshake(ca); }

X509Ptr certificate_of(EVP_PKEY* own, EVP_PKEY* issuer) {
  X509Ptr out(X509_new());
  const bool made =
      out && X509_set_version(out.get(), X509_VERSION_3) == 1 &&
      ASN1_INTEGER_set(X509_get_serialNumber(out.get()), 4711) == 1 &&
      X509_gmtime_adj(X509_getm_notBefore(out.get()), 0) != nullptr &&
      X509_gmtime_adj(X509_getm_notAfter(out.get()), 86400) != nullptr &&
      X509_NAME_add_entry_by_txt(X509_get_subject_name(out.get()), "CN", MBSTRING_UTF8,
                                 reinterpret_cast<const unsigned char*>("talker"), -1, -1,
                                 0) == 1 &&
      X509_set_pubkey(out.get(), own) == 1 && X509_sign(out.get(), issuer, EVP_sha256()) > 0;
  return made ? std::move(out) : nullptr;
}

bool forms(const Ca& ca) {
  const PkeyPtr own(EVP_EC_gen("P-256"));
  const auto certificate = own ? certificate_of(own.get(), ca.key.get()) : nullptr;
  const BioPtr out(BIO_new(BIO_s_mem()));
  const BioPtr text(BIO_new_mem_buf(kSigned.data(), static_cast<int>(kSigned.size())));
  if (!certificate || !out || !text) return false;
  constexpr unsigned kFlags = CMS_DETACHED | CMS_TEXT | CMS_STREAM;
  const CmsPtr document(CMS_sign(ca.certificate.get(), ca.key.get(), nullptr, text.get(), kFlags));
  return document && PEM_write_bio_X509(out.get(), certificate.get()) == 1 &&
         PEM_write_bio_PKCS8PrivateKey(out.get(), own.get(), nullptr, nullptr, 0, nullptr,
                                       nullptr) == 1 &&
         SMIME_write_CMS(out.get(), document.get(), text.get(), kFlags) == 1;
}

bool measure(const char* name, bool (*participant)(const Ca&), const Ca& ca, long count) {
  const auto began = std::clock();
  for (long i = 0; i < count; ++i)
    if (!participant(ca)) return false;
  std::printf("%s %.6f\n", name, static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC);
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const long count = argc == 2 ? std::strtol(argv[1], nullptr, 10) : 0;
  Ca ca{PkeyPtr(EVP_EC_gen("P-256")), nullptr};
  if (ca.key) ca.certificate = certificate_of(ca.key.get(), ca.key.get());
  if (count < 1 || !ca.certificate) {
    std::fputs("usage: bench_openssl_operations COUNT\n", stderr);
    return 2;
  }
  const bool good = measure("bare", bare, ca, count) && measure("forms", forms, ca, count) &&
                    measure("handshake", handshake, ca, count);
  return good ? 0 : 1;
}
