#include "pki/certificate_source.hpp"

#include "pki/openssl.hpp"
#include "pki/pkcs11.hpp"

namespace ddssec::pki {

Result<Bytes> load_certificates(std::string_view uri, std::string_view property,
                                std::size_t max_octets) {
  if (!names_token(uri)) return load_uri(uri, property, max_octets);
  DDSSEC_ASSIGN_OR_RETURN(const auto held,
                          with_default_document(token_certificate(uri), std::string(property)));
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (!bio || PEM_write_bio_X509(bio.get(), held.get()) != 1) return openssl_error(Code::internal);
  return to_bytes(bio_octets(bio));
}

Result<std::string> uri_of(const std::filesystem::path& path) {
  const auto file = "file://" + path.string();
  if (path.extension() != ".p11") return file;
  constexpr std::size_t kMax = 4096;
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, load_uri(file, path.string(), kMax));
  const auto text = as_text(octets);
  auto uri = std::string(text.substr(0, text.find_first_of("\r\n")));
  if (names_token(uri)) return uri;
  return fail(Code::unsupported_uri, {.document = path, .expected = "a line pkcs11:..."});
}

Error file_error(const Error& error, const std::filesystem::path& path) {
  auto details = error.details();
  details.document = path;
  if (details.found == path) details.found.clear();
  return Error(error.code(), std::move(details));
}

}  // namespace ddssec::pki
