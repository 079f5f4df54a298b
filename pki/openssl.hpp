// Internal to pki/: OpenSSL objects that free themselves, and the private members of the classes.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <openssl/asn1.h>
#include <openssl/bio.h>
#include <openssl/bn.h>
#include <openssl/cms.h>
#include <openssl/ec.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/param_build.h>
#include <openssl/pem.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include "base/clock.hpp"
#include "pki/certificate.hpp"
#include "pki/crl.hpp"
#include "pki/private_key.hpp"

namespace ddssec::pki {

template <auto Free>
struct Deleter {
  template <class T>
  void operator()(T* p) const noexcept {
    Free(p);
  }
};
inline void free_openssl_memory(void* p) noexcept { OPENSSL_free(p); }
inline void free_name(X509_NAME* p) noexcept { X509_NAME_free(p); }
inline void free_certificate_stack(STACK_OF(X509) * p) noexcept { sk_X509_free(p); }

using Asn1StringPtr = std::unique_ptr<ASN1_STRING, Deleter<ASN1_STRING_free>>;
using Asn1IntegerPtr = std::unique_ptr<ASN1_INTEGER, Deleter<ASN1_INTEGER_free>>;
using Asn1EnumeratedPtr = std::unique_ptr<ASN1_ENUMERATED, Deleter<ASN1_ENUMERATED_free>>;
using Asn1TimePtr = std::unique_ptr<ASN1_TIME, Deleter<ASN1_TIME_free>>;
using Asn1TypePtr = std::unique_ptr<ASN1_TYPE, Deleter<ASN1_TYPE_free>>;
using Asn1ObjectPtr = std::unique_ptr<ASN1_OBJECT, Deleter<ASN1_OBJECT_free>>;
using AuthorityKeyIdPtr = std::unique_ptr<AUTHORITY_KEYID, Deleter<AUTHORITY_KEYID_free>>;
using BioPtr = std::unique_ptr<BIO, Deleter<BIO_free_all>>;
using BignumPtr = std::unique_ptr<BIGNUM, Deleter<BN_free>>;
using BignumContextPtr = std::unique_ptr<BN_CTX, Deleter<BN_CTX_free>>;
using GroupPtr = std::unique_ptr<EC_GROUP, Deleter<EC_GROUP_free>>;
using ParameterBuilderPtr = std::unique_ptr<OSSL_PARAM_BLD, Deleter<OSSL_PARAM_BLD_free>>;
using ParametersPtr = std::unique_ptr<OSSL_PARAM, Deleter<OSSL_PARAM_free>>;
using PointPtr = std::unique_ptr<EC_POINT, Deleter<EC_POINT_free>>;
using SecretBignumPtr = std::unique_ptr<BIGNUM, Deleter<BN_clear_free>>;
using CmsPtr = std::unique_ptr<CMS_ContentInfo, Deleter<CMS_ContentInfo_free>>;
using CrlPtr = std::unique_ptr<X509_CRL, Deleter<X509_CRL_free>>;
using DigestPtr = std::unique_ptr<EVP_MD, Deleter<EVP_MD_free>>;
using AccessPtr = std::unique_ptr<AUTHORITY_INFO_ACCESS, Deleter<AUTHORITY_INFO_ACCESS_free>>;
using ExtensionPtr = std::unique_ptr<X509_EXTENSION, Deleter<X509_EXTENSION_free>>;
using NamePtr = std::unique_ptr<X509_NAME, Deleter<free_name>>;
using OpensslMemoryPtr = std::unique_ptr<unsigned char, Deleter<free_openssl_memory>>;
using OpensslTextPtr = std::unique_ptr<char, Deleter<free_openssl_memory>>;
using PkeyPtr = std::unique_ptr<EVP_PKEY, Deleter<EVP_PKEY_free>>;
using PkeyContextPtr = std::unique_ptr<EVP_PKEY_CTX, Deleter<EVP_PKEY_CTX_free>>;
using RequestPtr = std::unique_ptr<X509_REQ, Deleter<X509_REQ_free>>;
using RevokedPtr = std::unique_ptr<X509_REVOKED, Deleter<X509_REVOKED_free>>;
using StorePtr = std::unique_ptr<X509_STORE, Deleter<X509_STORE_free>>;
using StoreContextPtr = std::unique_ptr<X509_STORE_CTX, Deleter<X509_STORE_CTX_free>>;
using CertificateStackPtr = std::unique_ptr<STACK_OF(X509), Deleter<free_certificate_stack>>;
using X509Ptr = std::unique_ptr<X509, Deleter<X509_free>>;

struct Certificate::Impl {
  X509Ptr x509;
  Bytes der;
  std::string pem;
  std::string subject;
  std::string subject_one_line;
  std::string issuer;
  Sha256Digest fingerprint;
  Sha256Digest subject_digest;
  WallTime not_before;
  WallTime not_after;
  KeyAlgorithm key;
};

struct PrivateKey::Impl {
  PkeyPtr pkey;
  KeyAlgorithm algorithm;
  bool in_token = false;
};

struct Crl::Impl {
  CrlPtr crl;
  std::string issuer;
  WallTime this_update;
  std::optional<WallTime> next_update;
};

/// Gives pki/ access to the private members of the classes.
struct PkiAccess {
  using CertificateImpl = Certificate::Impl;
  using CrlImpl = Crl::Impl;
  using PrivateKeyImpl = PrivateKey::Impl;
  static const CertificateImpl& of(const Certificate& it) { return *it.impl_; }
  static const CrlImpl& of(const Crl& it) { return *it.impl_; }
  static const PrivateKeyImpl& of(const PrivateKey& it) { return *it.impl_; }
  /// Makes an object that holds `impl`, which must not be nullptr.
  template <class T>
  static T make(std::shared_ptr<const typename T::Impl> impl) {
    return T(std::move(impl));
  }
};
const auto& impl_of(const auto& it) { return PkiAccess::of(it); }

/// Returns the last reason in OpenSSL's queue, or "" if there is none, and empties the queue.
std::string take_openssl_reason();

/// Returns the library context for reading certificates. OpenSSL 3.0 asks every decoder of every
/// provider for the public key of a certificate, which takes several times as long as verifying the
/// certificate's signature. This context has the algorithms of OpenSSL's default provider, but only
/// the decoders of allowed public keys (see judge_key). The result is nullptr (OpenSSL's own
/// context) if that is configured for FIPS or without the default provider, or if memory is short.
/// Never freed, because certificates outlive everything else. Thread-safe.
OSSL_LIB_CTX* certificate_context();

/// Makes an error with OpenSSL's last reason as its note.
std::unexpected<Error> openssl_failure(Code code, ErrorDetails details = {});

/// Makes a reading BIO over borrowed octets; nullptr if they are too many for OpenSSL.
BioPtr bio_over(BytesView octets);

/// Returns a key identifier in hexadecimal digits; "" for nullptr.
std::string key_id_text(const ASN1_OCTET_STRING* id);

/// Returns the number of a list; empty if it has none or a negative one.
std::optional<CrlNumber> number_of(const X509_CRL* crl);

/// Returns the content of a memory BIO; valid until it changes.
BytesView bio_octets(const BioPtr& bio);

/// Converts a time of a certificate or revocation list. Error: malformed if OpenSSL cannot read it.
Result<WallTime> to_wall_time(const ASN1_TIME* time);

/// Converts the time to the form that certificates use (UTCTime up to 2049).
Result<Asn1TimePtr> to_asn1_time(WallTime time);

/// Returns RFC 2253 text: last RDN first, non-ASCII octets escaped.
std::string name_rfc2253(const X509_NAME* name);

/// Succeeds if a subject or issuer name has an allowed form. Error: name_not_allowed.
Status check_name(const X509_NAME* name, const char* which);

/// Returns a serial number in upper-case hexadecimal digits; "" if it cannot be read.
std::string serial_text(const ASN1_INTEGER* serial);

/// Returns a UTF-8 copy of an attribute's value; empty if it is not text or contains a NUL.
std::optional<std::string> to_utf8(const ASN1_STRING* value);

/// Returns the kind of an allowed public key: RSA of 2048 to 16384 bits, EC P-256 and P-384 with a
/// named curve. Error: key_not_allowed with algorithm and size, or with `type` if `key` is nullptr
/// because OpenSSL could not decode it.
Result<KeyAlgorithm> judge_key(EVP_PKEY* key, std::string_view type = "unknown type");

/// One block of a PEM text.
struct PemBlock {
  std::string label;
  Bytes der;
};

/// True if the octets begin with a SEQUENCE in DER, as certificates, lists and keys in DER do.
bool is_der(BytesView octets);

/// Reads the next PEM block, and skips text between blocks; nothing at the end. Refuses encrypted
/// blocks (malformed).
Result<std::optional<PemBlock>> next_pem_block(BIO* bio);

}  // namespace ddssec::pki
