// Delta revocation lists (RFC 5280 5.2.4), which our own authority does not make.
#pragma once

#include <string>

#include "base/bytes.hpp"
#include "pki/authority.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::test {

/// Returns `list` of `ca` with the extension `nid`, signed again, as PEM.
inline std::string with_extension(const pki::Crl& list, const pki::Authority& ca, int nid,
                                  void* value, bool is_critical) {
  const pki::CrlPtr crl(X509_CRL_dup(impl_of(list).crl.get()));
  const pki::BioPtr bio(BIO_new(BIO_s_mem()));
  if (X509_CRL_add1_ext_i2d(crl.get(), nid, value, is_critical ? 1 : 0, 0) != 1 ||
      X509_CRL_sign(crl.get(), impl_of(ca.key()).pkey.get(), EVP_sha256()) <= 0 ||
      PEM_write_bio_X509_CRL(bio.get(), crl.get()) != 1)
    return {};
  return std::string(as_text(pki::bio_octets(bio)));
}

/// Returns `list` of `ca` with the extension `nid` in its first entry, signed again, as PEM.
inline std::string with_entry_extension(const pki::Crl& list, const pki::Authority& ca, int nid,
                                        void* value, bool is_critical) {
  const pki::CrlPtr crl(X509_CRL_dup(impl_of(list).crl.get()));
  const pki::BioPtr bio(BIO_new(BIO_s_mem()));
  auto* const entry = sk_X509_REVOKED_value(X509_CRL_get_REVOKED(crl.get()), 0);
  if (X509_REVOKED_add1_ext_i2d(entry, nid, value, is_critical ? 1 : 0, X509V3_ADD_REPLACE) != 1 ||
      X509_CRL_sign(crl.get(), impl_of(ca.key()).pkey.get(), EVP_sha256()) <= 0 ||
      PEM_write_bio_X509_CRL(bio.get(), crl.get()) != 1)
    return {};
  return std::string(as_text(pki::bio_octets(bio)));
}

/// Returns `list` as a delta list since the list number `base` of `ca`, as PEM.
inline std::string delta_pem(const pki::Crl& list, const pki::Authority& ca, std::uint64_t base) {
  const pki::Asn1IntegerPtr number(ASN1_INTEGER_new());
  ASN1_INTEGER_set_uint64(number.get(), base);
  return with_extension(list, ca, NID_delta_crl, number.get(), true);
}

}  // namespace ddssec::test
