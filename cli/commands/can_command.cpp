// can: reports what the documents allow a participant, and which line decides.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/ca/revocation_lists.hpp"
#include "cli/commands/groups.hpp"
#include "cli/doctor/doctor_options.hpp"
#include "cli/doctor/participant_diagnosis.hpp"
#include "cli/documents/documents.hpp"
#include "cli/folders/folder_kind.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "governance/decision.hpp"
#include "governance/doctor/ca_list.hpp"
#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/domains_of_folder.hpp"
#include "governance/doctor/product_decision.hpp"
#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "governance/refusal_advice.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
namespace doctor = governance::doctor;

Result<governance::Action> action_of(const Arguments& arguments) {
  const auto word = arguments.text("ACTION");
  if (word == "publish") return governance::Action::publish;
  if (word == "subscribe") return governance::Action::subscribe;
  return fail(Code::usage, {.field = "ACTION", .expected = "publish or subscribe", .found = word});
}

Code code_of(governance::Action action) {
  return action == governance::Action::publish ? Code::publish_not_allowed
                                               : Code::subscribe_not_allowed;
}

// The answer for a participant, and the source of the answer.
struct Ruling {
  bool allowed;
  std::string because;
  fs::path document;
  int line;
  std::string hint = {};  // what to do if the grant refuses
};

// A question about a participant.
struct Question {
  const doctor::LoadedFolder& folder;
  governance::Action action;
  governance::Request request;
  DomainId domain;
  WallTime now;
};

doctor::Diagnosis diagnosis_for(const Question& question) {
  return diagnosis_of(question.folder,
                      {.now = question.now, .domain = question.domain, .may_run_elsewhere = true});
}

// Returns why the participant does not start at all, as `check` reports it.
std::optional<Ruling> by_doctor(const Question& question) {
  const auto diagnosis = diagnosis_for(question);
  for (const auto& check : diagnosis.checks()) {
    const auto worst = check.outcomes.ddssec;
    const bool is_about_topics = check.rule == Rule::DOC103 && worst == doctor::Outcome::late;
    if (worst < doctor::Outcome::late || check.findings.empty() || is_about_topics) continue;
    const auto& finding = check.findings.front();
    return Ruling{
        false,
        fmt::format("the participant does not start: {}: {}", info(check.rule).id, finding.message),
        finding.document, finding.line};
  }
  return std::nullopt;
}

// The verified governance document and the valid grant, ready to evaluate.
struct Documents {
  std::shared_ptr<const governance::CompiledGovernance> governance;
  std::shared_ptr<const governance::CompiledGrant> grant;
};

Result<Documents> documents_for(const Question& question) {
  const auto& paths = question.folder.paths;
  DDSSEC_ASSIGN_OR_RETURN(const auto governance_proof,
                          verified(paths.governance, paths.permissions_ca, question.now));
  auto governance_read = with_default_document(
      governance::read_governance(governance_proof.content(), governance_proof.first_line()),
      paths.governance);
  DDSSEC_RETURN_IF_ERROR(governance_read);
  auto governance_document =
      std::make_shared<const governance::Governance>(*std::move(governance_read));
  DDSSEC_ASSIGN_OR_RETURN(
      auto governance, with_default_document(governance::CompiledGovernance::make(
                                                 std::move(governance_document), question.domain),
                                             paths.governance));
  DDSSEC_ASSIGN_OR_RETURN(const auto certificate, read_certificate(paths.certificate));
  DDSSEC_ASSIGN_OR_RETURN(const auto proof,
                          verified(paths.permissions, paths.permissions_ca, question.now));
  auto read = with_default_document(
      governance::read_permissions(proof.content(), proof.first_line()), paths.permissions);
  DDSSEC_RETURN_IF_ERROR(read);
  const auto permissions = std::make_shared<const governance::Permissions>(*std::move(read));
  DDSSEC_ASSIGN_OR_RETURN(
      const auto* grant,
      with_default_document(governance::find_grant(*permissions, pki::SubjectName::of(certificate),
                                                   certificate.subject(), question.now),
                            paths.permissions));
  auto compiled =
      std::make_shared<const governance::CompiledGrant>(permissions, *grant, question.domain);
  return Documents{std::move(governance), std::move(compiled)};
}

// Adds what `doctor` advises if a file of the participant is missing.
Result<Documents> documents_or_advice(const Question& question) {
  auto out = documents_for(question);
  if (out || out.error().code() != Code::file_not_found) return out;
  auto details = out.error().details();
  const auto diagnosis = diagnosis_for(question);
  for (const auto& check : diagnosis.checks())
    for (const auto& finding : check.findings)
      if (check.rule == Rule::DOC001 && finding.document == details.document)
        details.hint = finding.hint.empty() ? std::string(info(Rule::DOC001).hint) : finding.hint;
  return fail(Code::file_not_found, std::move(details));
}

// Judges the certificate as every peer does.
Status check_identity(const Question& question) {
  if (!question.folder.certificate) return std::unexpected(question.folder.certificate.error());
  DDSSEC_ASSIGN_OR_RETURN(const auto verifier, question.folder.chain());
  DDSSEC_RETURN_IF_ERROR(
      with_default_document(verifier.verify(*question.folder.certificate, question.now),
                            question.folder.paths.certificate));
  return {};
}

Ruling by_grant(const Question& question, const governance::CompiledGrant& grant,
                const governance::Decision& decision, std::string_view what) {
  const auto who = decision.rule == nullptr ? "no rule decides; the default"
                   : decision.allowed       ? "an allow_rule"
                                            : "a deny_rule";
  return {decision.allowed, fmt::format("{}{} of grant \"{}\"", what, who, grant.grant().name),
          question.folder.paths.permissions, decision.line(grant.grant())};
}

// True if the chain verifier of ddssec's plugins would ignore the list.
bool is_superseded(const pki::Crl& list, const std::vector<pki::Crl>& lists,
                   const std::vector<pki::Certificate>& cas) {
  return std::ranges::any_of(lists, [&](const pki::Crl& other) {
    return &other != &list && other.is_not_older_than(list) && !list.is_not_older_than(other) &&
           pki::have_common_signer(other, list, cas);
  });
}

// A revoked participant has no rights, whatever its documents say: its peers refuse it. The CA's
// own list also counts if it is beside the participant.
std::optional<Ruling> by_revocation(const pki::ParticipantFolder& folder) {
  const auto certificate = read_certificate(folder.certificate);
  const auto cas = read_certificates(folder.identity_ca);
  const auto own = read_crls(folder.crl);
  if (!certificate || !cas || !own) return std::nullopt;  // doctor reports that it cannot be read
  const auto newer = governance::doctor::newer_ca_list(folder, *cas, *own);
  const auto answer = [&](const pki::Crl& list, const fs::path& file) {
    return Ruling{false,
                  fmt::format("the certificate is revoked by list {} of the CA", number_text(list)),
                  file, 0};
  };
  if (newer && governance::doctor::lists_certificate(newer->list, *certificate)) {
    auto out = answer(newer->list, newer->file);
    out.because += ", which crl.pem here lacks: participants without that list still accept it";
    out.hint =
        "give the other participants the list, and they refuse it: ddssec crl distribute --ca CA, "
        "which leaves out this folder";
    return out;
  }
  for (const auto& list : *own)
    if (!is_superseded(list, *own, *cas) &&
        governance::doctor::lists_certificate(list, *certificate))
      return answer(list, folder.crl);
  return std::nullopt;
}

// Adds a note if stock products use another list than ddssec's plugins, for which the answer was
// given.
void note_stock_products(const doctor::LoadedFolder& folder, Report& report) {
  if (!folder.crls || !folder.certificate || !folder.identity_cas || folder.crls->size() < 2)
    return;
  const auto& lists = *folder.crls;
  const auto names = [&](const pki::Crl& list) {
    return doctor::lists_certificate(list, *folder.certificate);
  };
  const bool ours = std::ranges::any_of(lists, [&](const pki::Crl& list) {
    return !is_superseded(list, lists, *folder.identity_cas) && names(list);
  });
  const bool stock = names(lists.front());
  if (ours == stock) return;
  report.findings.push_back(
      {.rule = Rule::DOC023,
       .message = fmt::format(
           "{} holds {} lists; the stock plugins of Cyclone DDS and Fast DDS read the first only, "
           "by which {} is {}revoked; {}",
           folder.paths.crl.string(), lists.size(), folder.certificate->subject(),
           stock ? "" : "not ", ours ? "ddssec's plugins refuse it" : "ddssec's plugins do not"),
       .document = folder.paths.crl.string(),
       .hint = "keep the newest alone: ddssec crl distribute --ca CA",
       .severity = Severity::warning});
}

// Adds a note if Cyclone DDS's own plugins do not even create the topic. Measured with 0.10.2, if
// both directions of the topic are controlled.
void note_refused_topic(const Question& question, Report& report) {
  const auto& [folder, action, request, domain, now] = question;
  if (!folder.permissions.model || !folder.governance.model || !folder.certificate) return;
  const auto cyclonedds = doctor::Product::cyclonedds;
  const auto* const rules = doctor::domain_rule_as(cyclonedds, *folder.governance.model, domain);
  const auto* const controlled =
      rules != nullptr ? doctor::topic_rule_as(cyclonedds, *rules, request.topic) : nullptr;
  if (controlled == nullptr || !controlled->enable_read_access_control ||
      !controlled->enable_write_access_control)
    return;
  const auto& certificate = *folder.certificate;
  const auto grant = governance::find_grant(
      *folder.permissions.model, pki::SubjectName::of(certificate), certificate.subject(), now);
  const auto* const first =
      grant ? doctor::first_rule_naming(**grant, domain, request.topic) : nullptr;
  if (first == nullptr || first->allow) return;
  report.findings.push_back(
      {.rule = Rule::DOC053,
       .message = fmt::format("Cyclone DDS 0.10 on its own plugins refuses the whole topic \"{}\", "
                              "in every direction and partition: the first rule that names it is a "
                              "deny_rule",
                              request.topic),
       .document = folder.paths.permissions.string(),
       .line = first->line,
       .products = {"cyclonedds"},
       .severity = Severity::warning});
}

// Adds a note if only the plugins within Cyclone DDS refuse the endpoint, and the folder does not
// say that they are used: a program may name them in its QoS.
void note_drop_in(const Question& question, Report& report) {
  const auto& folder = question.folder;
  if (!folder.governance.model || runs_drop_in(folder)) return;
  constexpr auto kDdssec = doctor::Product::ddssec;
  const auto* const rules =
      doctor::domain_rule_as(kDdssec, *folder.governance.model, question.domain);
  const auto* const rule =
      rules != nullptr ? doctor::topic_rule_as(kDdssec, *rules, question.request.topic) : nullptr;
  if (rule == nullptr) return;
  auto finding = refused_by_drop_in(folder, *rules, *rule, question.action);
  if (!finding) return;
  finding->severity = Severity::warning;
  report.findings.push_back(*std::move(finding));
}

// Also warns of the places in Fast DDS's file, because the question names no product.
void warn_of_places(const Question& question, Report& report) {
  const auto diagnosis = diagnosis_for(question);
  for (const auto& check : diagnosis.checks())
    if (check.rule == Rule::DOC007)
      report.findings.insert(report.findings.end(), check.findings.begin(), check.findings.end());
}

// For an enclave of ROS 2, new permissions are made from the policy, which has the topics of every
// node.
std::string permission_hint(const Question& question) {
  if (question.folder.paths.layout == pki::FolderLayout::sros2)
    return "add the topic to the enclave's policy, then: ddssec keystore permission KEYSTORE "
           "ENCLAVE --policy POLICY --node-defaults";
  return std::string(info(code_of(question.action)).hint);
}

// Takes the same steps as `check`: identity, grant, joining, topic rule and rights.
Result<Ruling> answer_to(const Question& question) {
  if (auto answer = by_revocation(question.folder.paths)) return *std::move(answer);
  DDSSEC_ASSIGN_OR_RETURN(const auto documents, documents_or_advice(question));
  const auto& [governance, grant] = documents;
  DDSSEC_RETURN_IF_ERROR(check_identity(question));
  const auto& domain_rule = governance->domain_rule();
  const auto joining = grant->judge_participant();
  if (domain_rule.enable_join_access_control && !joining.allowed)
    return by_grant(question, *grant, joining, fmt::format("joining domain {}: ", question.domain));
  if (auto answer = by_doctor(question)) return *std::move(answer);
  const auto& file = question.folder.paths.governance;
  const auto* rule = governance->topic_rule(question.request.topic);
  if (rule == nullptr)
    return Ruling{false, "no topic_rule matches the topic", file, domain_rule.line};
  if (runs_drop_in(question.folder))
    if (const auto finding =
            refused_by_drop_in(question.folder, domain_rule, *rule, question.action))
      return Ruling{false, fmt::format("{}: {}", info(finding->rule).id, finding->message), file,
                    rule->line, std::string(info(finding->rule).hint)};
  const bool controlled = question.action == governance::Action::publish
                              ? rule->enable_write_access_control
                              : rule->enable_read_access_control;
  if (!controlled)
    return Ruling{true, "the topic_rule \"" + rule->topic_expression + "\" asks for no permission",
                  file, rule->line};
  const auto decision = grant->judge(question.action, question.request);
  auto out = by_grant(question, *grant, decision, "");
  const auto advice = advice_on(*grant, question.action, question.request, decision);
  if (!advice.because.empty()) out.because += "; " + advice.because;
  // The question names no partition, so the answer must not look as if it covered partitions.
  if (decision.allowed && decision.criteria != nullptr && question.request.partitions.empty())
    if (const auto where = partitions_of(*decision.criteria); !where.empty())
      out.because += ", but " + where;
  if (!decision.allowed) out.hint = !advice.hint.empty() ? advice.hint : permission_hint(question);
  return out;
}

// If there are several domains, the user must choose, because the answer may differ.
Result<DomainId> domain_to_ask(const Arguments& arguments, const doctor::LoadedFolder& folder,
                               WallTime now) {
  if (arguments.has("--domain")) return domain_of(arguments);
  const doctor::Domains named[] = {domains_of(folder, now)};
  const auto choice = doctor::choose_domain(named);
  if (!choice.has_others()) return choice.domain;
  return fail(Code::usage, {.field = "--domain",
                            .expected = "one of " + doctor::to_text(choice.named),
                            .found = "none",
                            .note = "the documents are for more than one domain"});
}

struct UseVerdict {
  bool allowed;
  DomainId domain;
  std::string judge, because;
  fs::path file;
  int line;

  static constexpr auto fields() {
    return std::tuple(field<&UseVerdict::allowed>(), field<&UseVerdict::domain>(),
                      field<&UseVerdict::judge>({.words = "ddssec"}), field<&UseVerdict::because>(),
                      field<&UseVerdict::file>(), field<&UseVerdict::line>());
  }
  std::string text() const {
    return fmt::format("{} in domain {} by {}'s plugins: {} ({}{})\n",
                       allowed ? "allowed" : "denied", domain, judge, because,
                       printable(file.string()), line > 0 ? fmt::format(":{}", line) : "");
  }
};

Result<Answer<UseVerdict>> can(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto action, action_of(arguments));
  const auto now = context.clock.calendar_seconds();
  DDSSEC_RETURN_IF_ERROR(check_participant_folder(arguments.text("SUBJECT")));
  const auto folder = load_participant(arguments.text("SUBJECT"), now);
  DDSSEC_ASSIGN_OR_RETURN(const auto domain, domain_to_ask(arguments, folder, now));
  const auto topic = arguments.text("TOPIC");
  const auto& names = arguments.all("--partition");
  const std::vector<std::string_view> partitions(names.begin(), names.end());
  const Question question{folder, action, {.topic = topic, .partitions = partitions}, domain, now};
  DDSSEC_ASSIGN_OR_RETURN(const auto ruling, answer_to(question));
  Answer<UseVerdict> out{
      {ruling.allowed, domain, "ddssec", ruling.because, ruling.document, ruling.line}};
  auto& report = out.report;
  if (!ruling.allowed) report.exit = Exit::no;
  if (!ruling.hint.empty())
    report.errors.emplace_back(code_of(action), ErrorDetails{.document = ruling.document,
                                                             .line = ruling.line,
                                                             .found = ruling.because,
                                                             .hint = ruling.hint});
  warn_of_places(question, report);
  note_stock_products(folder, report);
  if (ruling.allowed) {
    note_refused_topic(question, report);
    note_drop_in(question, report);
  }
  return out;
}

}  // namespace

std::vector<Command> can_commands() {
  return {{.group = "",
           .name = "can",
           .summary = "Says whether ddssec's plugins let a participant use a topic, and which line "
                      "decides; exit 1: no.",
           .positionals = {{"SUBJECT", "the participant's folder"},
                           {"ACTION", "publish or subscribe"},
                           {"TOPIC", "the topic's name"}},
           .options = {kDomainToCheck, repeated("--partition", "P", "a partition of the endpoint")},
           .examples = {"ddssec can talker publish rt/chatter"},
           .run = can}};
}

}  // namespace ddssec::cli
