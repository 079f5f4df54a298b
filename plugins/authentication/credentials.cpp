#include "plugins/authentication/credentials.hpp"

#include <vector>

#include "plugins/authentication/algorithms.hpp"
#include "plugins/authentication/ocsp_status.hpp"
#include "plugins/authentication/participant_data.hpp"

namespace ddssec::authentication {
namespace {

constexpr FieldRule kParticipantData{"c.pdata", 1, kMaxParticipantDataOctets};
constexpr FieldRule kSignatureAlgorithm{"c.dsign_algo", 1, 128};
constexpr FieldRule kKeyAgreementAlgorithm{"c.kagree_algo", 1, 128};

std::vector<spi::NamedOctets> in_order(const Credentials& c) {
  std::vector<spi::NamedOctets> fields = {{kCertificate.name, c.id}};
  if (c.permissions) fields.push_back({kPermissions.name, *c.permissions});
  fields.push_back({kParticipantData.name, c.participant_data});
  fields.push_back({kSignatureAlgorithm.name, c.signature_algorithm});
  fields.push_back({kKeyAgreementAlgorithm.name, c.key_agreement_algorithm});
  return fields;
}

}  // namespace

Result<Credentials> Credentials::read(const TokenFields& fields) {
  DDSSEC_ASSIGN_OR_RETURN(const auto key_agreement_octets, fields.required(kKeyAgreementAlgorithm));
  DDSSEC_ASSIGN_OR_RETURN(const auto signature_octets, fields.required(kSignatureAlgorithm));
  const auto signature_name = algorithm_text(signature_octets);
  if (!is_signature_algorithm(signature_name))
    return fail(Code::signature_algorithm_unknown, {.field = std::string(kSignatureAlgorithm.name),
                                                    .found = std::string(signature_name)});
  const auto key_agreement_name = algorithm_text(key_agreement_octets);
  const auto kind = key_agreement_kind_from(key_agreement_name);
  if (!kind)
    return fail(Code::key_agreement_algorithm_unknown,
                {.field = std::string(kKeyAgreementAlgorithm.name),
                 .found = std::string(key_agreement_name)});
  DDSSEC_ASSIGN_OR_RETURN(const auto id, fields.required(kCertificate));
  DDSSEC_ASSIGN_OR_RETURN(const auto permissions, fields.optional(kPermissions));
  DDSSEC_ASSIGN_OR_RETURN(const auto participant_data, fields.required(kParticipantData));
  DDSSEC_ASSIGN_OR_RETURN(const auto ocsp_status, fields.optional(kOcspStatus));
  return Credentials{.id = id,
                     .permissions = permissions,
                     .participant_data = participant_data,
                     .signature_algorithm = signature_octets,
                     .key_agreement_algorithm = key_agreement_octets,
                     .key_agreement = *kind,
                     .ocsp_status = ocsp_status};
}

void Credentials::write(spi::Token& token) const {
  for (const auto& field : in_order(*this)) add_field(token, field.name, field.value);
}

Sha256Digest Credentials::hash() const {
  return sha256(spi::serialize_binary_properties(in_order(*this)));
}

void add_field(spi::Token& token, std::string_view name, BytesView value) {
  token.binary_properties.push_back({std::string(name), to_bytes(value)});
}

}  // namespace ddssec::authentication
