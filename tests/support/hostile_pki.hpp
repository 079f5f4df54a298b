// Certificates and signatures that harm some patch levels of OpenSSL, made with OpenSSL itself.
#pragma once

#include <string>

#include <openssl/pkcs7.h>
#include <openssl/x509v3.h>

#include "pki/authority.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::test {

inline void free_points(STACK_OF(DIST_POINT) * points) { CRL_DIST_POINTS_free(points); }

/// The form in which a CRL distribution point is named.
enum class PointName { full, relative, relative_to_named_issuer };

inline DIST_POINT* distribution_point(PointName form, const X509_NAME* issuer) {
  DIST_POINT* point = DIST_POINT_new();
  point->distpoint = DIST_POINT_NAME_new();
  point->distpoint->type = form == PointName::full ? 0 : 1;
  if (form == PointName::full) {
    point->distpoint->name.fullname = GENERAL_NAMES_new();
    sk_GENERAL_NAME_push(
        point->distpoint->name.fullname,
        a2i_GENERAL_NAME(nullptr, nullptr, nullptr, GEN_URI, "http://ca/x.crl", 0));
    return point;
  }
  auto* entries = sk_X509_NAME_ENTRY_new_null();
  sk_X509_NAME_ENTRY_push(
      entries, X509_NAME_ENTRY_create_by_NID(nullptr, NID_commonName, MBSTRING_ASC,
                                             reinterpret_cast<const unsigned char*>("x"), 1));
  point->distpoint->name.relativename = entries;
  if (form == PointName::relative_to_named_issuer) {
    point->CRLissuer = GENERAL_NAMES_new();
    GENERAL_NAME* name = GENERAL_NAME_new();
    GENERAL_NAME_set0_value(name, GEN_DIRNAME, X509_NAME_dup(issuer));
    sk_GENERAL_NAME_push(point->CRLissuer, name);
  }
  return point;
}

/// Returns a certificate of `who` that names an issuer with `entries` attributes (20 octets each)
/// and has `count` CRL distribution points. It is signed again by its own key, so that only its
/// form is right.
inline std::string with_distribution_points(const pki::Credential& who, PointName form, int count,
                                            int entries) {
  const pki::X509Ptr x509(X509_dup(impl_of(who.certificate).x509.get()));
  const std::unique_ptr<X509_NAME, Deleter<X509_NAME_free>> issuer(X509_NAME_new());
  for (int i = 0; i < entries; ++i)
    X509_NAME_add_entry_by_NID(issuer.get(), NID_organizationalUnitName, MBSTRING_ASC,
                               reinterpret_cast<const unsigned char*>("123456789"), 9, -1, 0);
  X509_set_issuer_name(x509.get(), issuer.get());
  const std::unique_ptr<STACK_OF(DIST_POINT), Deleter<free_points>> points(CRL_DIST_POINTS_new());
  for (int i = 0; i < count; ++i)
    sk_DIST_POINT_push(points.get(), distribution_point(form, issuer.get()));
  const pki::BioPtr bio(BIO_new(BIO_s_mem()));
  if (X509_add1_ext_i2d(x509.get(), NID_crl_distribution_points, points.get(), 0, 0) != 1 ||
      X509_sign(x509.get(), impl_of(who.key).pkey.get(), EVP_sha256()) <= 0 ||
      PEM_write_bio_X509(bio.get(), x509.get()) != 1)
    return {};
  return std::string(as_text(pki::bio_octets(bio)));
}

using Pkcs7Ptr = std::unique_ptr<PKCS7, Deleter<PKCS7_free>>;

/// Returns `text` signed by `who` as PKCS#7, detached, with signed attributes.
inline Pkcs7Ptr pkcs7_of(const pki::Credential& who, std::string_view text, int flags) {
  const pki::BioPtr data = pki::bio_over(as_bytes(text));
  return Pkcs7Ptr(PKCS7_sign(impl_of(who.certificate).x509.get(), impl_of(who.key).pkey.get(),
                             nullptr, data.get(), flags));
}

/// Returns the S/MIME file that signs `text`. This signs it again, so changes to `pkcs7` must come
/// after this.
inline std::string smime_of(PKCS7* pkcs7, std::string_view text, int flags) {
  const pki::BioPtr data = pki::bio_over(as_bytes(text));
  const pki::BioPtr out(BIO_new(BIO_s_mem()));
  if (SMIME_write_PKCS7(out.get(), pkcs7, data.get(), flags) != 1) return {};
  return std::string(as_text(pki::bio_octets(out)));
}

inline Bytes der_of(PKCS7* pkcs7) {
  const pki::BioPtr bio(BIO_new(BIO_s_mem()));
  if (i2d_PKCS7_bio(bio.get(), pkcs7) != 1) return {};
  return to_bytes(pki::bio_octets(bio));
}

/// Returns the signed attributes of the only signer, to be changed. sign_attributes signs them
/// again.
inline STACK_OF(X509_ATTRIBUTE) * attributes_of(PKCS7* pkcs7) {
  return sk_PKCS7_SIGNER_INFO_value(PKCS7_get_signer_info(pkcs7), 0)->auth_attr;
}

inline bool sign_attributes(PKCS7* pkcs7) {
  return PKCS7_SIGNER_INFO_sign(sk_PKCS7_SIGNER_INFO_value(PKCS7_get_signer_info(pkcs7), 0)) == 1;
}

/// Makes a messageDigest of another type than OCTET STRING.
inline X509_ATTRIBUTE* message_digest_of_type(int type, const void* value, int size) {
  return X509_ATTRIBUTE_create_by_NID(nullptr, NID_pkcs9_messageDigest, type, value, size);
}

}  // namespace ddssec::test
