#include "pki/ocsp_fetch.hpp"

#include <algorithm>
#include <memory>

#include <openssl/http.h>
#include <openssl/ocsp.h>

#include "base/tool_code.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

using OcspRequestPtr = std::unique_ptr<OCSP_REQUEST, Deleter<OCSP_REQUEST_free>>;

void free_headers(STACK_OF(CONF_VALUE) * headers) noexcept {
  sk_CONF_VALUE_pop_free(headers, X509V3_conf_free);
}
using HeadersPtr = std::unique_ptr<STACK_OF(CONF_VALUE), Deleter<free_headers>>;

std::unexpected<Error> fetch_error(const std::string& url, std::string note) {
  return fail(tool_code::ocsp_fetch_failed, {.found = url, .note = std::move(note)});
}

// Larger than the limit of judge_ocsp, so that judge_ocsp reports a response that is too large.
constexpr std::size_t kMaxFetched = 64 * 1024;

// The request identifies the certificate with SHA-1, which every responder understands (RFC 5019).
Result<BioPtr> request_for(const OcspRequest& question) {
  const OcspRequestPtr request(OCSP_REQUEST_new());
  OCSP_CERTID* const id = OCSP_cert_to_id(EVP_sha1(), impl_of(question.certificate).x509.get(),
                                          impl_of(question.ca).x509.get());
  if (!request || id == nullptr || OCSP_request_add0_id(request.get(), id) == nullptr) {
    OCSP_CERTID_free(id);
    return openssl_error(Code::internal);
  }
  BioPtr bio(BIO_new(BIO_s_mem()));
  if (!bio || ASN1_i2d_bio(reinterpret_cast<i2d_of_void*>(i2d_OCSP_REQUEST), bio.get(),
                           reinterpret_cast<unsigned char*>(request.get())) != 1)
    return openssl_error(Code::internal);
  return bio;
}

// The Host header: several responders may share one address (virtual hosts).
Result<HeadersPtr> headers_for(const OcspAddress& address) {
  const auto host = address.port == "80" ? address.host : address.host + ":" + address.port;
  STACK_OF(CONF_VALUE)* headers = nullptr;
  const int added = X509V3_add_value("Host", host.c_str(), &headers);
  HeadersPtr out(headers);
  if (added != 1) return openssl_error(Code::internal);
  return out;
}

Bytes all_of(BIO* bio) {
  Bytes out(kMaxFetched);
  std::size_t size = 0;
  while (size < out.size()) {
    const int count = BIO_read(bio, out.data() + size, static_cast<int>(out.size() - size));
    if (count <= 0) break;
    size += static_cast<std::size_t>(count);
  }
  out.resize(size);
  return out;
}

}  // namespace

Result<Bytes> fetch_ocsp(const OcspRequest& question, const std::string& url,
                         std::chrono::seconds longest) {
  DDSSEC_ASSIGN_OR_RETURN(const auto address, parse_ocsp_address(url));
  DDSSEC_ASSIGN_OR_RETURN(const auto request, request_for(question));
  DDSSEC_ASSIGN_OR_RETURN(const auto headers, headers_for(address));
  // An empty proxy means that none is used, whatever the environment says: OpenSSL 3.0.17 reads
  // beyond the end of the variable no_proxy (CVE-2025-9232).
  const BioPtr answer(
      OSSL_HTTP_transfer(nullptr, address.host.c_str(), address.port.c_str(), address.path.c_str(),
                         0, "", nullptr, nullptr, nullptr, nullptr, nullptr, 0, headers.get(),
                         "application/ocsp-request", request.get(), "application/ocsp-response", 1,
                         kMaxFetched, static_cast<int>(longest.count()), 0));
  if (!answer) {
    const auto reason = take_openssl_reason();
    return fetch_error(url, reason.empty() ? "no answer" : reason);
  }
  auto octets = all_of(answer.get());
  take_openssl_reason();
  return octets;
}

}  // namespace ddssec::pki
