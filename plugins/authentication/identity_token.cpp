#include "plugins/authentication/identity_token.hpp"

#include "plugins/authentication/token_fields.hpp"

namespace ddssec::authentication {
namespace {

constexpr std::string_view kCertificateSubject = "dds.cert.sn";
constexpr std::string_view kCertificateAlgorithm = "dds.cert.algo";
constexpr std::string_view kCaSubject = "dds.ca.sn";
constexpr std::string_view kCaAlgorithm = "dds.ca.algo";

}  // namespace

spi::Token write_identity_token(const pki::Certificate& certificate, const pki::Certificate& ca) {
  spi::Token token{std::string(class_id_of(TokenClass::identity))};
  const auto add = [&](std::string_view name, std::string value) {
    token.properties.push_back({std::string(name), std::move(value)});
  };
  add(kCertificateSubject, certificate.subject_one_line());
  add(kCertificateAlgorithm, to_string(certificate.key_algorithm()));
  add(kCaSubject, ca.subject_one_line());
  add(kCaAlgorithm, to_string(ca.key_algorithm()));
  return token;
}

Result<IdentityClaim> read_identity_token(const spi::Token& token) {
  DDSSEC_TRY(TokenFields::of(token, TokenClass::identity));
  const std::string* subject = spi::find_property(token.properties, kCertificateSubject);
  return IdentityClaim{subject == nullptr ? std::string() : *subject};
}

}  // namespace ddssec::authentication
