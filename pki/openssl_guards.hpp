// Checks that refuse input before OpenSSL reads it, because some patch levels of OpenSSL have flaws
// with it. base/openssl_flaws.cpp lists them. Only sources of pki/ include this.
#pragma once

#include "base/result.hpp"
#include "pki/openssl_pointers.hpp"

namespace ddssec::pki {

/// The largest size of names, in octets, that OpenSSL may copy for the CRL distribution points of
/// certificates. For each point with a nameRelativeToCRLIssuer it copies the whole name of the
/// issuer. Such a point is rare and an issuer's name has some 100 octets, so an honest certificate
/// stays far below.
inline constexpr std::size_t kMaxDistributionPointOctets = 64 * 1024;

/// Succeeds if OpenSSL can safely read the certificate's extensions (CVE-2026-35189: a certificate
/// of 64 KiB takes hundreds of MiB). Call it before any other function that reads them:
/// X509_check_purpose and most functions about extensions. Errors: certificate_distribution_points,
/// certificate_malformed.
Status check_distribution_points(const X509* x509);

/// Succeeds if CMS_verify accepts the signature over `content` with the certificates in `trusted`,
/// which are `signer`'s. Errors: smime_message_digest, smime_signature_invalid with OpenSSL's
/// reason.
Status verify_cms(CMS_ContentInfo* cms, STACK_OF(X509) * trusted, BIO* content, unsigned flags,
                  std::string signer);

/// Succeeds if PKCS7_verify accepts the signature over `content` (nullptr: over the content inside)
/// with a chain to `store`. The signed octets are written to `out`. Errors: smime_digest_missing
/// (an empty set of digest algorithms made PKCS7_verify free `content`, CVE-2026-45447),
/// smime_message_digest (OpenSSL read it without regard to its type, CVE-2026-22796), those of
/// check_distribution_points for certificates inside, smime_signature_invalid with OpenSSL's
/// reason.
Status verify_pkcs7(PKCS7* pkcs7, X509_STORE* store, BIO* content, BIO* out, int flags);

}  // namespace ddssec::pki
