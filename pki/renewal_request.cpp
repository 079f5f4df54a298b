#include "pki/renewal_request.hpp"

#include <algorithm>

#include "pki/authority.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

BytesView name_octets(const X509_NAME* name) {
  const unsigned char* der = nullptr;
  std::size_t size = 0;
  return X509_NAME_get0_der(name, &der, &size) == 1 ? BytesView(der, size) : BytesView();
}

}  // namespace

Status check_renewal_request(BytesView request_pem, const Certificate& old, RequestedKey key) {
  DDSSEC_ASSIGN_OR_RETURN(const auto content, read_request(request_pem));
  const BioPtr bio = bio_over(request_pem);
  const RequestPtr request(PEM_read_bio_X509_REQ(bio.get(), nullptr, nullptr, nullptr));
  if (!request) return openssl_error(Code::request_invalid);
  X509* certificate = impl_of(old).x509.get();
  const auto wanted = name_octets(X509_get_subject_name(certificate));
  if (wanted.empty() ||
      !std::ranges::equal(wanted, name_octets(X509_REQ_get_subject_name(request.get()))))
    return fail(Code::request_invalid,
                {.expected = "the subject " + old.subject() + ", octet for octet",
                 .found = content.subject});
  if (key == RequestedKey::any ||
      EVP_PKEY_eq(X509_REQ_get0_pubkey(request.get()), X509_get0_pubkey(certificate)) == 1)
    return {};
  ERR_clear_error();
  return fail(Code::key_mismatch, {.expected = "a request with the key of " + old.subject(),
                                   .found = "one with another key"});
}

}  // namespace ddssec::pki
