#include "plugins/authentication/identity_token.hpp"

#include "plugins/authentication/token_fields.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

constexpr std::string_view kCertificateSubject = "dds.cert.sn";
constexpr std::string_view kCertificateAlgorithm = "dds.cert.algo";
constexpr std::string_view kCaSubject = "dds.ca.sn";
constexpr std::string_view kCaAlgorithm = "dds.ca.algo";

}  // namespace

spi::Token write_identity_token(const pki::Certificate& certificate, const pki::Certificate& ca,
                                spi::CipherMask ciphers) {
  spi::Token token{std::string(class_id_of(TokenClass::identity))};
  const auto add = [&](std::string_view name, std::string value) {
    token.properties.push_back({std::string(name), std::move(value)});
  };
  add(kCertificateSubject, certificate.subject_one_line());
  add(kCertificateAlgorithm, to_string(certificate.key_algorithm()));
  add(kCaSubject, ca.subject_one_line());
  add(kCaAlgorithm, to_string(ca.key_algorithm()));
  if (const auto ours = ciphers & ~spi::kStandardCiphers; ours != 0)
    add(spi::property::kAnnouncedCiphers, spi::names_of(ours));
  return token;
}

spi::CipherMask announced_ciphers(const spi::Token& identity_token) {
  const auto* const names =
      spi::find_property(identity_token.properties, spi::property::kAnnouncedCiphers);
  return spi::kStandardCiphers | (names == nullptr ? 0 : spi::ciphers_in(*names));
}

Result<IdentityClaim> read_identity_token(const spi::Token& token) {
  DDSSEC_RETURN_IF_ERROR(TokenFields::of(token, TokenClass::identity));
  const std::string* subject = spi::find_property(token.properties, kCertificateSubject);
  return IdentityClaim{subject == nullptr ? std::string() : *subject};
}

}  // namespace ddssec::authentication
