#include "cli/participant/participant.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.hpp"
#include "base/tool_code.hpp"
#include "cli/ca/signed_documents.hpp"
#include "cli/participant/configuration_files.hpp"
#include "governance/grant.hpp"
#include "governance/lint.hpp"
#include "governance/read.hpp"
#include "governance/write.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

std::vector<governance::Text> texts(const std::vector<std::string>& expressions) {
  std::vector<governance::Text> out;
  for (const auto& expression : expressions) out.push_back({expression, 0});
  return out;
}

governance::Grant grant_from_lists(const ParticipantSpec& spec) {
  governance::GrantRule rule{.allow = true, .domains = {.ranges = spec.domains}};
  const auto partitions =
      spec.partitions.empty() ? std::nullopt : std::optional(texts(spec.partitions));
  if (!spec.publish.empty())
    rule.publish.push_back({.topics = texts(spec.publish), .partitions = partitions});
  if (!spec.subscribe.empty())
    rule.subscribe.push_back({.topics = texts(spec.subscribe), .partitions = partitions});
  return {.name = spec.name, .rules = {std::move(rule)}};
}

// Every holder of the signed file can use each of its grants. An expression, or a name that cannot
// be parsed, counts as another subject.
Status check_own_grants(const governance::Permissions& document, const pki::SubjectName& own,
                        std::string_view shown) {
  constexpr std::size_t kMaxShown = 8;
  std::string names;
  std::size_t others = 0;
  int line = 0;
  for (const auto& grant : document.grants) {
    const auto subject = pki::SubjectName::parse(grant.subject_name);
    if (!grant.subject_is_expression && subject && subject->key() == own.key()) continue;
    if (others == 0) line = grant.line;
    if (++others <= kMaxShown)
      names += fmt::format("{}\"{}\"", others == 1 ? "" : ", ", printable(grant.subject_name));
  }
  if (others == 0) return {};
  if (others > kMaxShown) names += fmt::format(" and {} more", others - kMaxShown);
  return fail(tool_code::foreign_grant, {.line = line,
                                         .field = "<subject_name>",
                                         .expected = fmt::format("\"{}\" alone", shown),
                                         .found = std::move(names)});
}

// Refuses a CA's name: peers would take the certificate for a self-signed one, or for the CA's.
Status check_not_of_ca(const pki::Certificate& certificate, const Issuers& issuers) {
  const auto name = pki::SubjectName::of(certificate).key();
  for (const auto* ca : {&issuers.identity, issuers.permissions})
    if (ca != nullptr && pki::SubjectName::of(ca->certificate()).key() == name)
      return fail(Code::subject_taken, {.found = certificate.subject() + ", which is a CA's",
                                        .hint = "choose another subject name"});
  return {};
}

bool is_about_topics(Rule rule) {
  return rule == Rule::PERM012 || rule == Rule::PERM013 || rule == Rule::PERM034;
}

}  // namespace

void warn_of_rights(const ParticipantSpec& spec, const std::string& document, Report& report) {
  governance::Permissions rights;
  if (spec.permissions)
    rights = governance::read_permissions(*spec.permissions).value_or(governance::Permissions());
  else
    rights.grants = {spec.grant ? *spec.grant : grant_from_lists(spec)};
  for (auto& finding : lint(rights)) {
    const bool is_known = std::ranges::find(report.findings, finding.message, &Finding::message) !=
                          report.findings.end();
    const bool is_read_otherwise = spec.permissions && !finding.products.empty();
    if (is_known || (!is_about_topics(finding.rule) && !is_read_otherwise)) continue;
    finding.document = document;
    finding.severity = std::min(finding.severity, Severity::warning);
    report.findings.push_back(std::move(finding));
  }
}

Result<pki::Validity> within_ca(pki::Validity wanted, const pki::Certificate& ca, bool clamp) {
  if (wanted.not_after > ca.not_after()) {
    if (!clamp)
      return fail(Code::outlives_ca, {.expected = "an end before " + to_string(ca.not_after()),
                                      .found = to_string(wanted.not_after)});
    wanted.not_after = ca.not_after();
  }
  if (wanted.not_after <= ca.not_before())
    return fail(tool_code::ends_before_ca,
                {.expected = "an end after " + to_string(ca.not_before()),
                 .found = to_string(wanted.not_after)});
  wanted.not_before = std::max(wanted.not_before, ca.not_before());
  return wanted;
}

Result<std::string> permissions_xml(const ParticipantSpec& spec,
                                    const pki::Certificate& certificate, WallTime now) {
  if (spec.permissions) {
    DDSSEC_ASSIGN_OR_RETURN(const auto document, governance::read_permissions(*spec.permissions));
    DDSSEC_RETURN_IF_ERROR(governance::find_grant(document, pki::SubjectName::of(certificate),
                                                  certificate.subject(), now));
    if (!spec.takes_other_grants)
      DDSSEC_RETURN_IF_ERROR(
          check_own_grants(document, pki::SubjectName::of(certificate), certificate.subject()));
    return std::string(as_text(*spec.permissions));
  }
  auto grant = spec.grant ? *spec.grant : grant_from_lists(spec);
  grant.subject_name = certificate.subject();
  grant.validity = {certificate.not_before(), certificate.not_after()};
  auto xml = to_xml(governance::Permissions{.grants = {std::move(grant)}});
  // The document is parsed, because the requested rights may contain something that no document
  // can.
  DDSSEC_RETURN_IF_ERROR(governance::read_permissions(as_bytes(xml)));
  return xml;
}

Result<NewParticipant> make_participant(const ParticipantSpec& spec, const Issuers& issuers,
                                        const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(auto issued,
                          issuers.identity.authority.issue(spec.subject, spec.key, spec.life,
                                                           context.random, spec.ocsp_responder));
  NewParticipant out{
      .self = std::move(issued), .permissions_xml = {}, .permissions = {}, .dropin = spec.dropin};
  DDSSEC_RETURN_IF_ERROR(check_not_of_ca(out.self.certificate, issuers));
  if (!spec.has_permissions() || issuers.permissions == nullptr) return out;
  const auto now = context.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(out.permissions_xml, permissions_xml(spec, out.self.certificate, now));
  DDSSEC_ASSIGN_OR_RETURN(
      out.permissions,
      sign_permissions(issuers.permissions->authority, out.permissions_xml, now, context.random));
  return out;
}

Result<Bytes> sign_permissions(const pki::Authority& ca, std::string_view xml, WallTime now,
                               Random& random) {
  DDSSEC_ASSIGN_OR_RETURN(auto out, ca.sign_document(as_bytes(xml), now, random));
  if (out.size() <= pki::kMaxSentPermissionsOctets) return out;
  return fail(Code::smime_too_large,
              {.expected = fmt::format("at most {} octets", pki::kMaxSentPermissionsOctets),
               .found = fmt::format("{} octets when signed", out.size()),
               .note = "peers on ddssec's plugins do not take longer ones",
               .hint = "give each participant a document with its own grant, and write "
                       "expressions instead of many names"});
}

Status add_flat(NewFolder& folder, const fs::path& below, const NewParticipant& participant,
                const Issuers& issuers, BytesView governance) {
  const auto files = pki::participant_folder(below, pki::FolderLayout::flat);
  DDSSEC_RETURN_IF_ERROR(folder.add_public(files.identity_ca, issuers.identity.trust_pem));
  DDSSEC_RETURN_IF_ERROR(folder.add_public(files.certificate, participant.self.certificate.pem()));
  DDSSEC_ASSIGN_OR_RETURN(const auto pem, participant.self.key.to_pem());
  DDSSEC_RETURN_IF_ERROR(
      pem.expose([&](BytesView octets) { return folder.add(files.key, octets, 0600); }));
  if (!issuers.permissions_trust.empty())
    DDSSEC_RETURN_IF_ERROR(folder.add_public(files.permissions_ca, issuers.permissions_trust));
  if (!participant.permissions.empty())
    DDSSEC_RETURN_IF_ERROR(folder.add(files.permissions, participant.permissions, 0644));
  if (!governance.empty()) DDSSEC_RETURN_IF_ERROR(folder.add(files.governance, governance, 0644));
  if (!issuers.crl.empty()) DDSSEC_RETURN_IF_ERROR(folder.add_public(files.crl, issuers.crl));
  const auto finally = folder.target() / below;
  for (const auto& [name, text] : configuration_files(
           pki::participant_folder(finally, pki::FolderLayout::flat), participant.dropin))
    DDSSEC_RETURN_IF_ERROR(folder.add_public(below / name, text));
  return {};
}

std::string log_line(const NewParticipant& participant, const fs::path& folder, WallTime now) {
  std::error_code ignored;
  return pki::IssueLog::issued_line(participant.self.certificate,
                                    fs::absolute(folder, ignored).lexically_normal().string(), now);
}

std::string signed_line(const NewParticipant& participant, const OpenCa& permissions,
                        const fs::path& folder, WallTime now) {
  if (participant.permissions.empty()) return {};
  return signed_line(permissions.certificate(), as_bytes(participant.permissions_xml),
                     pki::participant_folder(folder).permissions, now);
}

}  // namespace ddssec::cli
