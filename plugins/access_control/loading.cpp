#include "plugins/access_control/loading.hpp"

#include <algorithm>
#include <array>

#include <fmt/format.h>

#include "governance/read.hpp"
#include "pki/certificate_source.hpp"
#include "plugins/access_control/allowed_algorithms.hpp"
#include "plugins/access_control/protection.hpp"
#include "plugins/spi/files_poll_interval.hpp"
#include "plugins/spi/property_names.hpp"
#include "plugins/spi/renewal_list_places.hpp"

namespace ddssec::access_control {
namespace {

// Returns the name of a document for people: its path, or the property if the document is in the
// property itself.
std::string document_name(std::string_view property, std::string_view uri) {
  const auto start = uri.find_first_not_of(" \t");
  if (start != uri.npos && uri.substr(start).starts_with("file:")) {
    return std::string(uri.substr(start + 5));
  }
  return std::string(property);
}

// Returns the places of the three documents and of the identity CA.
Result<DocumentPlaces> places_of(const spi::PropertyList& properties) {
  constexpr std::array kNames = {spi::property::kPermissionsCa, spi::property::kGovernance,
                                 spi::property::kPermissions};
  std::array<std::string, kNames.size()> values;
  std::string missing;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (const auto* value = spi::find_property(properties, kNames[i])) values[i] = *value;
    if (values[i].empty()) missing += fmt::format("{}{}", missing.empty() ? "" : ", ", kNames[i]);
  }
  if (std::ranges::all_of(values, &std::string::empty)) return fail(Code::access_not_configured);
  if (!missing.empty()) {
    return fail(Code::access_document_missing, {.expected = missing, .found = "empty or not set"});
  }
  DDSSEC_ASSIGN_OR_RETURN(auto renewal_list, spi::renewal_list_places(properties));
  return DocumentPlaces{
      .permissions_ca = values[0],
      .governance = values[1],
      .permissions = values[2],
      .identity_ca = std::string(spi::property_value(properties, spi::property::kIdentityCa)),
      .renewal_list = std::move(renewal_list),
      .permissions_ca_name = document_name(kNames[0], values[0]),
      .governance_name = document_name(kNames[1], values[1]),
      .permissions_name = document_name(kNames[2], values[2])};
}

// Returns the result of `read` for the certificates that a property names.
template <class Read>
auto certificates_of(const spi::PropertyList& properties, std::string_view property,
                     std::size_t max_octets, Read&& read) -> decltype(read(BytesView())) {
  const auto* uri = spi::find_property(properties, property);
  if (!uri || uri->empty()) return fail(Code::missing_property, {.field = std::string(property)});
  DDSSEC_ASSIGN_OR_RETURN(const auto file, pki::load_certificates(*uri, property, max_octets));
  return with_default_document(read(file), document_name(property, *uri));
}

Result<pki::Certificate> local_certificate(const spi::PropertyList& properties) {
  return certificates_of(properties, spi::property::kIdentityCertificate,
                         pki::kMaxCertificateOctets, pki::Certificate::from_pem);
}

// The algorithms of our own certificate are checked here and not in authentication, because hosts
// call authentication before there is a governance.
Status check_own_algorithms(JudgingDocuments& documents, const pki::Certificate& certificate,
                            const spi::PropertyList& properties) {
  const auto* const allowed = documents.allowed_algorithms();
  if (allowed == nullptr) return {};
  DDSSEC_ASSIGN_OR_RETURN(
      documents.identity_authorities,
      certificates_of(properties, spi::property::kIdentityCa, pki::kMaxBundleOctets,
                      pki::Certificate::bundle_from_pem));
  DDSSEC_RETURN_IF_ERROR(check_identity(*allowed, certificate, documents.identity_authorities));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto signers,
      certificates_of(properties, spi::property::kPermissionsCa, pki::kMaxBundleOctets,
                      pki::Certificate::bundle_from_pem));
  for (const auto& signer : signers) DDSSEC_RETURN_IF_ERROR(check_authority(*allowed, signer));
  return {};
}

Result<JudgingDocuments> first_judging_documents(const LoadContext& context,
                                                 const LocalParticipant& participant,
                                                 const DocumentPlaces& places,
                                                 BytesView governance_file) {
  JudgingDocuments out;
  DDSSEC_ASSIGN_OR_RETURN(out.ca, with_default_document(PermissionsCa::load(places.permissions_ca),
                                                        places.permissions_ca_name));
  DDSSEC_ASSIGN_OR_RETURN(
      auto verified,
      with_default_document(
          compile_governance({*out.ca, participant, context.options}, governance_file, context.now),
          places.governance_name));
  out.governance = std::move(verified.rules);
  out.governance_digest = verified.digest;
  return out;
}

// Returns the octets of a property that a host may carry as binary or as text.
std::optional<BytesView> octets_of(const spi::Token& token, std::string_view name) {
  std::optional<BytesView> octets;
  if (const auto* text = spi::find_property(token.properties, name)) octets = as_bytes(*text);
  if (const auto* binary = spi::find_binary_property(token, name)) octets = BytesView(*binary);
  // Some peers count the NUL at the end of their text.
  if (octets && !octets->empty() && octets->back() == 0) octets = octets->first(octets->size() - 1);
  if (octets && octets->empty()) return std::nullopt;
  return octets;
}

// True for the plugin's name in any letter case with the same major version. No version means 1.0
// (DDS-Security 1.2, clause 10.4.2.2).
bool is_compatible_class(std::string_view class_id) {
  constexpr std::string_view kPlugin = "DDS:Access:Permissions";
  const auto lower = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  if (!std::ranges::equal(class_id.substr(0, kPlugin.size()), kPlugin, {}, lower, lower)) {
    return false;
  }
  const auto version = class_id.substr(kPlugin.size());
  return version.empty() || version == ":1" || version.starts_with(":1.");
}

// The handshake sends the document, and accepts no longer one. The check is here because the file
// is known here.
Status check_own_size(const DocumentPlaces& places, BytesView file) {
  if (file.size() <= pki::kMaxSentPermissionsOctets) return {};
  return fail(Code::file_too_large,
              {.document = places.permissions_name,
               .expected = fmt::format("at most {} octets, since peers are sent it",
                                       pki::kMaxSentPermissionsOctets),
               .found = fmt::format("{}", file.size()),
               .hint = "give each participant a document with its own grant only, and cover topics "
                       "with expressions such as Sensor*"});
}

}  // namespace

Result<VerifiedGovernance> compile_governance(const GovernanceContext& context, BytesView file,
                                              WallTime now) {
  DDSSEC_ASSIGN_OR_RETURN(const auto document, context.ca.verifier().verify(file, now));
  DDSSEC_ASSIGN_OR_RETURN(auto rules,
                          governance::read_governance(document.content(), document.first_line()));
  auto content = std::make_shared<const governance::Governance>(std::move(rules));
  DDSSEC_ASSIGN_OR_RETURN(auto compiled, governance::CompiledGovernance::make(
                                             std::move(content), context.participant.domain,
                                             context.participant.domain_tag));
  DDSSEC_RETURN_IF_ERROR(check_enforceable(compiled->domain_rule(), context.options));
  return VerifiedGovernance{std::move(compiled), sha256(document.content())};
}

Result<std::shared_ptr<PermissionsHolder>> load_local(const LoadContext& context,
                                                      spi::IdentityHandle identity, DomainId domain,
                                                      const spi::PropertyList& properties,
                                                      std::string_view domain_tag) {
  DDSSEC_ASSIGN_OR_RETURN(const auto places, places_of(properties));
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, local_certificate(properties));
  HolderSubject subject{pki::SubjectName::of(certificate), certificate.subject()};
  auto participant = std::make_shared<LocalParticipant>();
  participant->identity = identity;
  participant->domain = domain;
  participant->domain_tag = domain_tag;
  DDSSEC_ASSIGN_OR_RETURN(participant->warn_before_end, spi::warning_days(properties));
  participant->governance_name = places.governance_name;
  DDSSEC_ASSIGN_OR_RETURN(const auto interval, spi::files_poll_interval(properties));
  auto own = std::make_unique<OwnDocuments>(places, context.options, interval);
  DDSSEC_ASSIGN_OR_RETURN(
      auto governance_file,
      pki::load_uri(places.governance, spi::property::kGovernance, pki::kMaxDocumentOctets));
  DDSSEC_ASSIGN_OR_RETURN(auto documents,
                          first_judging_documents(context, *participant, places, governance_file));
  DDSSEC_RETURN_IF_ERROR(with_default_document(
      check_own_algorithms(documents, certificate, properties), participant->governance_name));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto file,
      pki::load_uri(places.permissions, spi::property::kPermissions, pki::kMaxDocumentOctets));
  DDSSEC_RETURN_IF_ERROR(check_own_size(places, file));
  own->note_read(std::move(governance_file), file);
  DDSSEC_ASSIGN_OR_RETURN(
      auto document,
      with_default_document(context.documents.permissions(*documents.ca, file, context.now),
                            places.permissions_name));
  DDSSEC_RETURN_IF_ERROR(participant->set_judging_documents(std::move(documents)));
  auto holder =
      std::make_shared<PermissionsHolder>(std::move(participant), std::nullopt, std::move(subject),
                                          places.permissions_name, std::move(document));
  holder->set_own(std::string(as_text(file)), std::move(own));
  DDSSEC_RETURN_IF_ERROR(holder->grant(context.now));
  return holder;
}

Status check_remote_algorithms(const LocalParticipant& local, const spi::Token& credential,
                               HolderSubject& subject) {
  const auto documents = local.judging_documents();
  const auto* const allowed = documents->allowed_algorithms();
  const auto octets = octets_of(credential, "c.id");
  if (allowed == nullptr || !octets) return {};
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, pki::Certificate::from_pem(*octets));
  subject = {pki::SubjectName::of(certificate), certificate.subject()};
  DDSSEC_RETURN_IF_ERROR(check_identity(*allowed, certificate, documents->identity_authorities));
  const auto agreement = octets_of(credential, "c.kagree_algo");
  return check_key_establishment(*allowed,
                                 agreement ? std::optional(as_text(*agreement)) : std::nullopt);
}

Result<std::shared_ptr<PermissionsDocument>> judge_remote(const LoadContext& context,
                                                          const LocalParticipant& local,
                                                          const spi::Token& permissions_token,
                                                          const spi::Token& credential,
                                                          HolderSubject& subject) {
  const auto certificate_octets = octets_of(credential, "c.id");
  if (!certificate_octets) return fail(Code::peer_certificate_missing, {.field = "c.id"});
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, pki::Certificate::from_pem(*certificate_octets));
  subject = {pki::SubjectName::of(certificate), certificate.subject()};
  if (!is_compatible_class(permissions_token.class_id)) {
    return fail(Code::permissions_token_class,
                {.field = "class_id",
                 .expected = std::string(spi::class_id::kPermissions),
                 .found = permissions_token.class_id.substr(0, 100)});
  }
  // Fast DDS and the standard use the name from the credential token, Cyclone DDS the one from the
  // handshake.
  auto file = octets_of(credential, "c.perm");
  if (!file) file = octets_of(credential, "dds.perm.cert");
  if (!file) return fail(Code::permissions_missing, {.field = "c.perm"});
  if (file->size() > context.options.max_permissions_octets) {
    return fail(Code::permissions_too_large,
                {.field = "c.perm",
                 .expected = std::to_string(context.options.max_permissions_octets) + " octets",
                 .found = std::to_string(file->size())});
  }
  DDSSEC_ASSIGN_OR_RETURN(auto document, context.documents.permissions(
                                             *local.judging_documents()->ca, *file, context.now));
  DDSSEC_RETURN_IF_ERROR(document->grant_for(subject.name, subject.shown, local.domain,
                                             local.domain_tag, context.now));
  return document;
}

}  // namespace ddssec::access_control
