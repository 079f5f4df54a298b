#include "pki/smime.hpp"

#include <algorithm>

#include <openssl/provider.h>

#include "pki/certificate_source.hpp"
#include "pki/openssl.hpp"
#include "pki/openssl_guards.hpp"
#include "pki/pki_access.hpp"
#include "pki/signing_time.hpp"
#include "pki/unverified_document.hpp"

namespace ddssec::pki {
namespace {

// The library context for decoding a signature. The certificates inside are not used. Without
// algorithms OpenSSL does not decode their keys, which would take longer than to verify the
// signature. Returns nullptr if OpenSSL cannot create the context.
OSSL_LIB_CTX* no_algorithms() {
  static OSSL_LIB_CTX* const context = [] {
    OSSL_LIB_CTX* made = OSSL_LIB_CTX_new();
    if (made != nullptr) OSSL_PROVIDER_load(made, "null");
    return made;
  }();
  return context;
}

Result<CmsPtr> decode_signature(BytesView der) {
  const auto* position = der.data();
  CmsPtr cms(static_cast<CMS_ContentInfo*>(static_cast<void*>(
      ASN1_item_d2i_ex(nullptr, &position, static_cast<long>(der.size()),
                       ASN1_ITEM_rptr(CMS_ContentInfo), no_algorithms(), nullptr))));
  if (!cms || position != der.data() + der.size())
    return openssl_error(Code::smime_signature_malformed);
  if (OBJ_obj2nid(CMS_get0_type(cms.get())) != NID_pkcs7_signed)
    return fail(Code::smime_signature_malformed, {.expected = "PKCS#7 SignedData"});
  // Content inside the signature would be a second document besides the one that is parsed.
  ASN1_OCTET_STRING** inner = CMS_get0_content(cms.get());
  if (inner == nullptr || *inner != nullptr ||
      OBJ_obj2nid(CMS_get0_eContentType(cms.get())) != NID_pkcs7_data)
    return openssl_error(Code::smime_signature_malformed, {.expected = "detached data"});
  return cms;
}

Result<CMS_SignerInfo*> only_signer(CMS_ContentInfo* cms) {
  auto* signers = CMS_get0_SignerInfos(cms);
  const int count = signers != nullptr ? sk_CMS_SignerInfo_num(signers) : 0;
  if (count <= 0) return fail(Code::smime_no_signer);
  if (count > 1) return fail(Code::smime_several_signers, {.found = std::to_string(count)});
  return sk_CMS_SignerInfo_value(signers, 0);
}

// True if the signature algorithm matches the digest. It only repeats the types of key and digest,
// and it is not signed.
bool fits(int signature_algorithm, int digest) {
  switch (signature_algorithm) {
    case NID_rsaEncryption:
    case NID_rsassaPss:
    case NID_X9_62_id_ecPublicKey:
      return true;
    default:
      break;
  }
  int named_digest = NID_undef;
  return OBJ_find_sigid_algs(signature_algorithm, &named_digest, nullptr) == 1 &&
         named_digest == digest;
}

Status check_digest(CMS_SignerInfo* signer) {
  X509_ALGOR* digest = nullptr;
  X509_ALGOR* signature = nullptr;
  CMS_SignerInfo_get0_algs(signer, nullptr, nullptr, &digest, &signature);
  const int nid = OBJ_obj2nid(digest->algorithm);
  if (nid != NID_sha256 && nid != NID_sha384 && nid != NID_sha512) {
    const char* name = OBJ_nid2sn(nid);
    return fail(Code::smime_digest_too_weak, {.expected = "SHA-256, SHA-384 or SHA-512",
                                              .found = name != nullptr ? name : "unknown"});
  }
  if (!fits(OBJ_obj2nid(signature->algorithm), nid))
    return fail(Code::smime_signature_malformed, {.field = "signature algorithm"});
  return {};
}

std::string describe(CMS_SignerInfo* signer) {
  X509_NAME* issuer = nullptr;
  ASN1_INTEGER* serial = nullptr;
  if (CMS_SignerInfo_get0_signer_id(signer, nullptr, &issuer, &serial) != 1 || issuer == nullptr)
    return "a signer named by key identifier";
  const BignumPtr number(ASN1_INTEGER_to_BN(serial, nullptr));
  const OpensslTextPtr hex(number ? BN_bn2hex(number.get()) : nullptr);
  return "certificate " + std::string(hex ? hex.get() : "?") + " issued by " + name_rfc2253(issuer);
}

// True if the signer names a configured root as its issuer. A root signs with its own name as
// issuer, so the signer is an earlier certificate of that root, or one that the root issued.
bool is_of_other_key(CMS_SignerInfo* signer, const std::vector<Certificate>& cas) {
  X509_NAME* issuer = nullptr;
  if (CMS_SignerInfo_get0_signer_id(signer, nullptr, &issuer, nullptr) != 1 || issuer == nullptr)
    return false;
  return std::ranges::any_of(cas, [&](const auto& ca) {
    return ca.is_self_issued() &&
           X509_NAME_cmp(issuer, X509_get_subject_name(impl_of(ca).x509.get())) == 0;
  });
}

// Returns the configured certificates that the signer may mean. After a CA was renewed, it may be
// more than one.
Result<std::vector<Certificate>> candidates(CMS_SignerInfo* signer,
                                            const std::vector<Certificate>& cas) {
  std::vector<Certificate> out;
  for (const auto& ca : cas)
    if (CMS_SignerInfo_cert_cmp(signer, impl_of(ca).x509.get()) == 0) out.push_back(ca);
  if (!out.empty()) return out;
  std::string listed;
  for (const auto& ca : cas) listed += (listed.empty() ? "" : " or ") + ca.subject();
  ErrorDetails details{.expected = listed.substr(0, 512), .found = describe(signer)};
  if (is_of_other_key(signer, cas)) {
    details.note =
        "the CA of that name has another certificate: it was rotated since, or the signer is one "
        "that "
        "it issued";
    details.hint =
        "after ca rotate, sign the document again: ddssec governance sign (or permissions sign) "
        "FILE.xml --ca CA --replace; a certificate that the CA issued does not count as the CA";
  }
  return fail(Code::smime_signer_not_permissions_ca, std::move(details));
}

// Verifies content digest, signed attributes and signature with the key of `ca`. OpenSSL looks at
// no other certificate. The caller judges whether `ca` is valid.
Status verify_with(const Certificate& ca, CMS_ContentInfo* cms, BytesView content) {
  const CertificateStackPtr trusted(sk_X509_new_null());
  const BioPtr bio = bio_over(content);
  constexpr unsigned kFlags = CMS_NOINTERN | CMS_NO_SIGNER_CERT_VERIFY | CMS_BINARY;
  if (!trusted || !bio || sk_X509_push(trusted.get(), impl_of(ca).x509.get()) <= 0)
    return openssl_error(Code::internal);
  return verify_cms(cms, trusted.get(), bio.get(), kFlags, "signer " + ca.subject());
}

struct VerifiedSigner {
  Certificate signer;
  std::optional<WallTime> signing_time;
};

Result<VerifiedSigner> verified_signer(const std::vector<Certificate>& cas, BytesView signature,
                                       BytesView content) {
  DDSSEC_ASSIGN_OR_RETURN(CmsPtr cms, decode_signature(signature));
  DDSSEC_ASSIGN_OR_RETURN(auto* signer, only_signer(cms.get()));
  DDSSEC_RETURN_IF_ERROR(check_digest(signer));
  DDSSEC_ASSIGN_OR_RETURN(const auto possible, candidates(signer, cas));
  const auto time = signing_time_of(signer);
  Status status = verify_with(possible.front(), cms.get(), content);
  if (status) return VerifiedSigner{possible.front(), time};
  for (std::size_t i = 1; i < possible.size(); ++i) {
    // A structure remembers the certificate with which it was verified, so each further certificate
    // needs a fresh one.
    DDSSEC_ASSIGN_OR_RETURN(cms, decode_signature(signature));
    status = verify_with(possible[i], cms.get(), content);
    if (status) return VerifiedSigner{possible[i], time};
  }
  return std::unexpected(status.error());
}

}  // namespace

Result<DocumentVerifier> DocumentVerifier::make(std::vector<Certificate> permissions_cas) {
  DDSSEC_ASSIGN_OR_RETURN(auto chain_verifier, ChainVerifier::make(std::move(permissions_cas)));
  return DocumentVerifier(std::move(chain_verifier));
}

Result<SignedDocument> DocumentVerifier::verify(BytesView file, WallTime now) const {
  DDSSEC_ASSIGN_OR_RETURN(auto document, read_document(file));
  DDSSEC_ASSIGN_OR_RETURN(const auto by, verified_signer(permissions_cas(), document.signature,
                                                         document.signed_octets));
  DDSSEC_ASSIGN_OR_RETURN(auto proof, chain_.verify(by.signer, now));
  SignedDocument out(std::move(document.signed_octets), document.header_octets, document.first_line,
                     std::move(proof));
  out.signing_time_ = by.signing_time;
  return out;
}

}  // namespace ddssec::pki
