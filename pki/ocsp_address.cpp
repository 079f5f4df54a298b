#include "pki/ocsp_address.hpp"

#include <algorithm>
#include <memory>

#include <openssl/http.h>
#include <openssl/ocsp.h>

#include "base/tool_code.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

void free_texts(STACK_OF(OPENSSL_STRING) * texts) noexcept { X509_email_free(texts); }
using TextsPtr = std::unique_ptr<STACK_OF(OPENSSL_STRING), Deleter<free_texts>>;

std::unexpected<Error> url_error(const std::string& url, std::string note) {
  return fail(tool_code::ocsp_fetch_failed, {.found = url, .note = std::move(note)});
}

// Refuses control characters and blanks: a line break in the URL would let the certificate's issuer
// add header lines or a second HTTP request.
bool is_plain(std::string_view url) {
  return std::ranges::all_of(url, [](char c) { return c > ' ' && c < 0x7f; });
}

}  // namespace

std::string ocsp_responder_of(const Certificate& certificate) {
  const TextsPtr urls(X509_get1_ocsp(impl_of(certificate).x509.get()));
  for (int i = 0; i < sk_OPENSSL_STRING_num(urls.get()); ++i) {
    const std::string url = sk_OPENSSL_STRING_value(urls.get(), i);
    if (url.starts_with("http://") && is_plain(url)) return url;
  }
  return {};
}

Result<OcspAddress> parse_ocsp_address(const std::string& url) {
  if (!is_plain(url))
    return url_error(url, "it has blanks, or octets that are not printable ASCII");
  char *host = nullptr, *port = nullptr, *path = nullptr;
  int has_tls = 0;
  const int is_url = OSSL_HTTP_parse_url(url.c_str(), &has_tls, nullptr, &host, &port, nullptr,
                                         &path, nullptr, nullptr);
  const OpensslTextPtr owners[] = {OpensslTextPtr(host), OpensslTextPtr(port),
                                   OpensslTextPtr(path)};
  take_openssl_reason();
  if (is_url != 1 || host == nullptr || *host == 0 || port == nullptr || path == nullptr)
    return url_error(url, "it is not the address of a responder");
  // TLS is not needed: the response is signed, and an observer learns little that the handshake
  // does not show.
  if (has_tls != 0 || !url.starts_with("http://"))
    return url_error(url, "only http:// is used: the answer is signed");
  return OcspAddress{host, port, path};
}

}  // namespace ddssec::pki
