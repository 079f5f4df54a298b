#include "pki/openssl_guards.hpp"

#include <algorithm>

#include <openssl/pkcs7.h>
#include <openssl/x509v3.h>

#include "pki/openssl.hpp"

namespace ddssec::pki {
namespace {

void free_distribution_points(STACK_OF(DIST_POINT) * points) { CRL_DIST_POINTS_free(points); }
using DistributionPoints = std::unique_ptr<STACK_OF(DIST_POINT), Deleter<free_distribution_points>>;

std::size_t octets_of(const X509_NAME* name) {
  return static_cast<std::size_t>(std::max(i2d_X509_NAME(name, nullptr), 0));
}

// Returns the name to which a relative name of `point` is appended (RFC 5280 4.2.1.13).
const X509_NAME* base_name(const DIST_POINT* point, const X509* x509) {
  const int count = point->CRLissuer != nullptr ? sk_GENERAL_NAME_num(point->CRLissuer) : 0;
  for (int i = 0; i < count; ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(point->CRLissuer, i);
    if (name->type == GEN_DIRNAME) return name->d.directoryName;
  }
  return X509_get_issuer_name(x509);
}

bool is_relative(const DIST_POINT* point) {
  constexpr int kRelative = 1;  // nameRelativeToCRLIssuer in DistributionPointName
  return point->distpoint != nullptr && point->distpoint->type == kRelative;
}

// The amount of data that OpenSSL would copy.
struct Copies {
  std::size_t points = 0, octets = 0;
};

Status add(const X509* x509, Copies& to) {
  constexpr int kNone = -1;
  int found = kNone;
  const DistributionPoints points(static_cast<STACK_OF(DIST_POINT)*>(
      X509_get_ext_d2i(x509, NID_crl_distribution_points, &found, nullptr)));
  if (!points && found != kNone)
    return openssl_error(Code::certificate_malformed, {.field = "cRLDistributionPoints"});
  const int count = points ? sk_DIST_POINT_num(points.get()) : 0;
  for (int i = 0; i < count; ++i) {
    const DIST_POINT* point = sk_DIST_POINT_value(points.get(), i);
    if (!is_relative(point)) continue;
    ++to.points;
    to.octets += octets_of(base_name(point, x509));
  }
  return {};
}

Status check_copies(const Copies& copies) {
  if (copies.octets <= kMaxDistributionPointOctets) return {};
  return fail(Code::certificate_distribution_points,
              {.field = "cRLDistributionPoints",
               .expected = "at most " + std::to_string(kMaxDistributionPointOctets) +
                           " octets of issuer names for relative names",
               .found = std::to_string(copies.octets) + " octets for " +
                        std::to_string(copies.points) + " relative names"});
}

std::unexpected<Error> message_digest_error(std::string found) {
  return fail(Code::smime_message_digest, {.field = "signed attribute messageDigest",
                                           .expected = "one attribute with one OCTET STRING",
                                           .found = std::move(found)});
}

// Checks that the signed attributes hold one messageDigest with one value, an OCTET STRING (RFC
// 5652 11.2). `at(i)` returns attribute i of `count`.
template <class At>
Status check_message_digest(int count, At at) {
  if (count <= 0) return {};  // without signed attributes the content itself is signed
  X509_ATTRIBUTE* digest = nullptr;
  int found = 0;
  for (int i = 0; i < count; ++i) {
    X509_ATTRIBUTE* attribute = at(i);
    if (OBJ_obj2nid(X509_ATTRIBUTE_get0_object(attribute)) != NID_pkcs9_messageDigest) continue;
    digest = attribute;
    ++found;
  }
  if (found != 1) return message_digest_error(std::to_string(found) + " attributes");
  const int values = X509_ATTRIBUTE_count(digest);
  if (values != 1) return message_digest_error(std::to_string(values) + " values");
  const ASN1_TYPE* value = X509_ATTRIBUTE_get0_type(digest, 0);
  const int type = value != nullptr ? ASN1_TYPE_get(value) : V_ASN1_UNDEF;
  if (type != V_ASN1_OCTET_STRING) return message_digest_error(ASN1_tag2str(type));
  return {};
}

Status check_signer(const PKCS7_SIGNER_INFO* signer) {
  const auto* attributes = PKCS7_get_signed_attributes(signer);
  return check_message_digest(attributes != nullptr ? sk_X509_ATTRIBUTE_num(attributes) : 0,
                              [&](int i) { return sk_X509_ATTRIBUTE_value(attributes, i); });
}

Status check_signer(const CMS_SignerInfo* signer) {
  return check_message_digest(CMS_signed_get_attr_count(signer),
                              [&](int i) { return CMS_signed_get_attr(signer, i); });
}

Status check_signed_data(PKCS7* pkcs7) {
  if (PKCS7_type_is_signed(pkcs7) == 0 || pkcs7->d.sign == nullptr)
    return fail(Code::smime_signature_invalid, {.expected = "PKCS#7 SignedData"});
  const auto* algorithms = pkcs7->d.sign->md_algs;
  if (algorithms == nullptr || sk_X509_ALGOR_num(algorithms) < 1)
    return fail(Code::smime_digest_missing, {.field = "digestAlgorithms",
                                             .expected = "at least one algorithm",
                                             .found = "an empty set"});
  auto* signers = PKCS7_get_signer_info(pkcs7);
  const int count = signers != nullptr ? sk_PKCS7_SIGNER_INFO_num(signers) : 0;
  for (int i = 0; i < count; ++i)
    DDSSEC_RETURN_IF_ERROR(check_signer(sk_PKCS7_SIGNER_INFO_value(signers, i)));
  // OpenSSL builds the chain from the certificates inside, so these are checked, too.
  const auto* certificates = pkcs7->d.sign->cert;
  Copies copies;
  const int inside = certificates != nullptr ? sk_X509_num(certificates) : 0;
  for (int i = 0; i < inside; ++i)
    DDSSEC_RETURN_IF_ERROR(add(sk_X509_value(certificates, i), copies));
  return check_copies(copies);
}

}  // namespace

Status check_distribution_points(const X509* x509) {
  Copies copies;
  DDSSEC_RETURN_IF_ERROR(add(x509, copies));
  return check_copies(copies);
}

Status verify_cms(CMS_ContentInfo* cms, STACK_OF(X509) * trusted, BIO* content, unsigned flags,
                  std::string signer) {
  auto* signers = CMS_get0_SignerInfos(cms);
  const int count = signers != nullptr ? sk_CMS_SignerInfo_num(signers) : 0;
  for (int i = 0; i < count; ++i)
    DDSSEC_RETURN_IF_ERROR(check_signer(sk_CMS_SignerInfo_value(signers, i)));
  // CMS_verify makes a second BIO over a memory BIO, and leaks it if a digest is missing or unknown
  // (seen with OpenSSL 3.0.19). A peer's permissions could cause that in each handshake. With a
  // filter in front, CMS_verify makes no second BIO.
  const BioPtr filter(BIO_new(BIO_f_null()));
  if (!filter) return openssl_error(Code::internal);
  BIO_push(filter.get(), content);
  const bool is_verified = CMS_verify(cms, trusted, nullptr, filter.get(), nullptr, flags) == 1;
  BIO_pop(filter.get());  // the caller owns the content
  if (!is_verified)
    return openssl_error(Code::smime_signature_invalid, {.field = std::move(signer)});
  return {};
}

Status verify_pkcs7(PKCS7* pkcs7, X509_STORE* store, BIO* content, BIO* out, int flags) {
  DDSSEC_RETURN_IF_ERROR(check_signed_data(pkcs7));
  if (PKCS7_verify(pkcs7, nullptr, store, content, out, flags) != 1)
    return openssl_error(Code::smime_signature_invalid);
  return {};
}

}  // namespace ddssec::pki
