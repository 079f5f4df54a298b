// OCSP responses of any content, as a responder of the CA makes them.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include <openssl/ocsp.h>

#include "base/bytes.hpp"
#include "pki/authority.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::test {

/// One answer about one certificate.
struct OcspAnswer {
  pki::Certificate certificate;
  pki::Certificate ca;
  int status = V_OCSP_CERTSTATUS_GOOD;
  std::chrono::seconds this_update{0};  ///< counted from now
  std::optional<std::chrono::seconds> next_update = std::chrono::hours(24);
  const EVP_MD* id_digest = EVP_sha1();
  bool is_critical = false;  ///< true for an answer with a critical extension
};

struct OcspContent {
  std::vector<OcspAnswer> answers;
  pki::Certificate signer;
  pki::PrivateKey key;
  WallTime now;
  const EVP_MD* digest = EVP_sha256();
  std::vector<pki::Certificate> sent = {};
  bool by_key = false;  ///< true if the signer is named by its key
};

inline pki::Asn1TimePtr ocsp_time(WallTime time) {
  return pki::Asn1TimePtr(
      ASN1_GENERALIZEDTIME_set(nullptr, static_cast<time_t>(time.time_since_epoch().count())));
}

inline void add_answer(OCSP_BASICRESP* basic, const OcspAnswer& answer, WallTime now) {
  OCSP_CERTID* const id = OCSP_cert_to_id(answer.id_digest, impl_of(answer.certificate).x509.get(),
                                          impl_of(answer.ca).x509.get());
  const auto this_update = ocsp_time(now + answer.this_update);
  const auto next = answer.next_update ? ocsp_time(now + *answer.next_update) : nullptr;
  const auto revoked = ocsp_time(now - std::chrono::hours(1));
  const bool is_revoked = answer.status == V_OCSP_CERTSTATUS_REVOKED;
  auto* const single = OCSP_basic_add1_status(
      basic, id, answer.status, is_revoked ? OCSP_REVOKED_STATUS_KEYCOMPROMISE : 0,
      is_revoked ? revoked.get() : nullptr, this_update.get(), next.get());
  if (answer.is_critical)
    OCSP_SINGLERESP_add1_ext_i2d(single, NID_id_pkix_OCSP_archiveCutoff, this_update.get(), 1, 0);
  OCSP_CERTID_free(id);
}

/// Makes a response; empty if OpenSSL cannot make it.
inline Bytes ocsp_response(const OcspContent& content) {
  OCSP_BASICRESP* const basic = OCSP_BASICRESP_new();
  for (const auto& answer : content.answers) add_answer(basic, answer, content.now);
  for (const auto& one : content.sent) OCSP_basic_add1_cert(basic, impl_of(one).x509.get());
  const unsigned long flags = OCSP_NOCERTS | (content.by_key ? OCSP_RESPID_KEY : 0);
  if (OCSP_basic_sign(basic, impl_of(content.signer).x509.get(), impl_of(content.key).pkey.get(),
                      content.digest, nullptr, flags) != 1) {
    OCSP_BASICRESP_free(basic);
    return {};
  }
  OCSP_RESPONSE* const response = OCSP_response_create(OCSP_RESPONSE_STATUS_SUCCESSFUL, basic);
  unsigned char* octets = nullptr;
  const int size = i2d_OCSP_RESPONSE(response, &octets);
  const pki::OpensslMemoryPtr owner(octets);
  OCSP_RESPONSE_free(response);
  OCSP_BASICRESP_free(basic);
  return size <= 0 ? Bytes() : Bytes(octets, octets + size);
}

/// Makes the response of a responder that refuses to answer.
inline Bytes ocsp_refusal(int status) {
  OCSP_RESPONSE* const response = OCSP_response_create(status, nullptr);
  unsigned char* octets = nullptr;
  const int size = i2d_OCSP_RESPONSE(response, &octets);
  const pki::OpensslMemoryPtr owner(octets);
  OCSP_RESPONSE_free(response);
  return size <= 0 ? Bytes() : Bytes(octets, octets + size);
}

/// Makes a responder's key with a certificate of `ca`. Without `usage` it may not answer.
inline pki::Credential ocsp_delegate(const pki::Authority& ca, pki::Validity validity,
                                     Random& random, bool usage = true) {
  auto key = pki::PrivateKey::generate(pki::KeyKind::ec_p256, 0).value();
  const auto plain =
      ca.certify({.subject = "CN=OCSP responder,O=Example", .validity = validity}, key, random)
          .value();
  if (!usage) return {plain, std::move(key)};
  const pki::X509Ptr x509(X509_dup(impl_of(plain).x509.get()));
  const pki::ExtensionPtr extension(
      X509V3_EXT_conf_nid(nullptr, nullptr, NID_ext_key_usage, "OCSPSigning"));
  X509_add_ext(x509.get(), extension.get(), -1);
  X509_sign(x509.get(), impl_of(ca.key()).pkey.get(), EVP_sha256());
  unsigned char* octets = nullptr;
  const int size = i2d_X509(x509.get(), &octets);
  const pki::OpensslMemoryPtr owner(octets);
  return {pki::Certificate::from_der({octets, static_cast<std::size_t>(size)}).value(),
          std::move(key)};
}

}  // namespace ddssec::test
