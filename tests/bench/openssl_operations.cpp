// Measures the least work of OpenSSL for a participant. "bare" is a key and two signatures, on its
// certificate and on its permissions. "forms" is the same with the files that participants have:
// X.509, PKCS#8 and S/MIME. "handshake" is what the two sides of one handshake do with keys, where
// the message, the certificate and the permissions are signed octets. Prints the processor seconds
// of COUNT of each.
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>

#include <openssl/cms.h>
#include <openssl/pem.h>

#include "tests/bench/public_key_operations.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::pki;
using namespace ddssec::bench;

// A CA, and the substitute for its certificate.
struct Ca {
  PkeyPtr key;
  X509Ptr certificate;
};

bool bare(const Ca& ca) {
  const PkeyPtr own(EVP_EC_gen("P-256"));
  return own && !sign(ca.key.get()).empty() && !sign(ca.key.get()).empty();
}

bool handshake(const Ca& ca) {
  return half_a_handshake(ca.key.get(), 3) && half_a_handshake(ca.key.get(), 3);
}

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
