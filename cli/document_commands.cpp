// governance, permissions: signing and verifying documents; can: what they let a participant do.
#include <filesystem>

#include <fmt/format.h>

#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/transaction.hpp"
#include "governance/decision.hpp"
#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "pki/smime.hpp"
#include "pki/source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

template <class T>
Result<T> named(Result<T> result, const fs::path& path) {
  if (result) return result;
  return std::unexpected(result.error().in(path));
}

/// How a kind of document is read.
template <class T>
using Reader = Result<T> (*)(BytesView);

/// What other products may read in another way, one line each.
template <class T>
void add_notes(Report& report, const T& document, const fs::path& path) {
  report.result["notes"] = Json::array();
  for (const auto& note : document.notes) {
    report.text += fmt::format("note: {}, line {}: {}\n", path.string(), note.line, note.text);
    report.result["notes"].push_back({{"line", note.line}, {"text", note.text}});
  }
}

Result<pki::SignedDocument> verified(const fs::path& file, const fs::path& ca, WallTime now) {
  const auto octets = DDSSEC_TRY(read_file(file, pki::kMostDocumentOctets));
  auto anchors = named(
      pki::Certificate::bundle_from_pem(DDSSEC_TRY(read_file(ca, pki::kMostBundleOctets))), ca);
  const auto verifier =
      DDSSEC_TRY(named(pki::DocumentVerifier::make(DDSSEC_TRY(std::move(anchors))), ca));
  return named(verifier.verify(octets, now), file);
}

// A document that cannot be read is not worth a signature.
template <class T>
Result<Report> sign(Reader<T> read, const Arguments& arguments, const Context& context) {
  const fs::path from = arguments.text("FILE");
  const fs::path to = arguments.has("-o") ? fs::path(arguments.text("-o"))
                                          : fs::path(from).replace_extension("p7s");
  const auto octets = DDSSEC_TRY(read_file(from, pki::kMostDocumentOctets));
  const auto document = DDSSEC_TRY(named(read(octets), from));
  const auto ca = DDSSEC_TRY(load_ca(ca_folder(arguments.text("--ca"), "permissions"), arguments));
  const auto signed_octets =
      DDSSEC_TRY(named(ca.sign_document(octets, context.clock.now(), context.random), from));
  Report report;
  report.files_written.push_back(DDSSEC_TRY(write_new_file(to, signed_octets, 0644)));
  report.text = fmt::format("{}  signed by {}\n", to.string(), ca.certificate().subject());
  report.result = {{"file", to.string()}, {"signer", ca.certificate().subject()}};
  add_notes(report, document, from);
  return report;
}

template <class T>
Result<Report> verify(Reader<T> read, const Arguments& arguments, const Context& context) {
  const fs::path file = arguments.text("FILE");
  const auto proof = DDSSEC_TRY(verified(file, arguments.text("--ca"), context.clock.now()));
  const auto document = DDSSEC_TRY(named(read(proof.content()), file));
  Report report;
  report.text = fmt::format("{}: signed by {}, valid until {}\n", file.string(),
                            proof.signer().subject(), date(proof.signer_not_after()));
  report.result = {{"file", file.string()},
                   {"signer", proof.signer().subject()},
                   {"signer_sha256", to_hex(proof.signer().fingerprint())},
                   {"signer_not_after", to_string(proof.signer_not_after())}};
  add_notes(report, document, file);
  return report;
}

Result<governance::Action> action_of(const Arguments& arguments) {
  const auto word = arguments.text("ACTION");
  if (word == "publish") return governance::Action::publish;
  if (word == "subscribe") return governance::Action::subscribe;
  return fail(Code::usage, {.field = "ACTION", .expected = "publish or subscribe", .found = word});
}

/// A participant's answer and who gave it.
struct Answer {
  bool allowed;
  std::string because;
  fs::path document;
  int line;
};

// The governance document decides first: without access control nobody asks for permissions.
Result<std::optional<Answer>> by_governance(const fs::path& folder, governance::Action action,
                                            const std::string& topic, DomainId domain,
                                            WallTime now) {
  const auto file = folder / "governance.p7s";
  const auto proof = DDSSEC_TRY(verified(file, folder / "permissions_ca.pem", now));
  auto read = named(governance::read_governance(proof.content()), file);
  const auto document = std::make_shared<const governance::Governance>(DDSSEC_TRY(std::move(read)));
  const auto compiled =
      DDSSEC_TRY(named(governance::CompiledGovernance::make(document, domain), file));
  const auto* rule = compiled->topic_rule(topic);
  if (rule == nullptr)
    return Answer{false, "no topic_rule matches the topic", file, compiled->domain_rule().line};
  const bool controlled = action == governance::Action::publish ? rule->enable_write_access_control
                                                                : rule->enable_read_access_control;
  if (controlled) return std::nullopt;
  return Answer{true, "the topic_rule \"" + rule->topic_expression + "\" asks for no permission",
                file, rule->line};
}

Result<Answer> by_permissions(const fs::path& folder, governance::Action action,
                              const governance::Request& request, DomainId domain, WallTime now) {
  const auto file = folder / "permissions.p7s";
  const auto certificate = DDSSEC_TRY(read_certificate(folder / "cert.pem"));
  const auto proof = DDSSEC_TRY(verified(file, folder / "permissions_ca.pem", now));
  auto read = named(governance::read_permissions(proof.content()), file);
  const auto document =
      std::make_shared<const governance::Permissions>(DDSSEC_TRY(std::move(read)));
  const auto* grant =
      DDSSEC_TRY(named(governance::find_grant(*document, pki::SubjectName::of(certificate),
                                              certificate.subject(), now),
                       file));
  const governance::CompiledGrant compiled(document, *grant, domain);
  const auto verdict = compiled.judge(action, request);
  const auto what = verdict.rule == nullptr ? "no rule matches; the grant's default"
                    : verdict.allowed       ? "an allow_rule"
                                            : "a deny_rule";
  return Answer{verdict.allowed, fmt::format("{} of grant \"{}\"", what, grant->name), file,
                verdict.line(*grant)};
}

}  // namespace

Result<Report> governance_sign(const Arguments& arguments, const Context& context) {
  return sign(&governance::read_governance, arguments, context);
}
Result<Report> governance_verify(const Arguments& arguments, const Context& context) {
  return verify(&governance::read_governance, arguments, context);
}
Result<Report> permissions_sign(const Arguments& arguments, const Context& context) {
  return sign(&governance::read_permissions, arguments, context);
}
Result<Report> permissions_verify(const Arguments& arguments, const Context& context) {
  return verify(&governance::read_permissions, arguments, context);
}

Result<Report> can(const Arguments& arguments, const Context& context) {
  const fs::path folder = arguments.text("SUBJECT");
  const auto topic = arguments.text("TOPIC");
  const auto action = DDSSEC_TRY(action_of(arguments));
  const auto domain = static_cast<DomainId>(
      DDSSEC_TRY(arguments.number("--domain", 0, governance::kHighestDomainId)));
  const auto& names = arguments.all("--partition");
  const std::vector<std::string_view> partitions(names.begin(), names.end());
  const auto now = context.clock.now();
  auto answer = DDSSEC_TRY(by_governance(folder, action, topic, domain, now));
  if (!answer)
    answer = DDSSEC_TRY(
        by_permissions(folder, action, {.topic = topic, .partitions = partitions}, domain, now));
  return Report{
      .exit = answer->allowed ? Exit::done : Exit::no,
      .text = fmt::format("{}: {} ({}, line {})\n", answer->allowed ? "allowed" : "denied",
                          answer->because, answer->document.string(), answer->line),
      .result = {{"allowed", answer->allowed},
                 {"because", answer->because},
                 {"file", answer->document.string()},
                 {"line", answer->line}}};
}

}  // namespace ddssec::cli
