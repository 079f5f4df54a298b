// can: what the documents let a participant do, and which line decides.
#include <filesystem>

#include <fmt/format.h>

#include "cli/ca_folder.hpp"
#include "cli/documents.hpp"
#include "cli/groups.hpp"
#include "cli/inputs.hpp"
#include "cli/options.hpp"
#include "governance/decision.hpp"
#include "governance/doctor/ca_list.hpp"
#include "governance/grant.hpp"
#include "governance/read.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

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
Result<std::optional<Answer>> by_governance(const pki::ParticipantFolder& folder,
                                            governance::Action action, const std::string& topic,
                                            DomainId domain, WallTime now) {
  const auto& file = folder.governance;
  const auto proof = DDSSEC_TRY(verified(file, folder.permissions_ca, now));
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

Result<Answer> by_permissions(const pki::ParticipantFolder& folder, governance::Action action,
                              const governance::Request& request, DomainId domain, WallTime now) {
  const auto& file = folder.permissions;
  const auto certificate = DDSSEC_TRY(read_certificate(folder.certificate));
  const auto proof = DDSSEC_TRY(verified(file, folder.permissions_ca, now));
  auto read = named(governance::read_permissions(proof.content()), file);
  const auto document =
      std::make_shared<const governance::Permissions>(DDSSEC_TRY(std::move(read)));
  const auto* grant =
      DDSSEC_TRY(named(governance::find_grant(*document, pki::SubjectName::of(certificate),
                                              certificate.subject(), now),
                       file));
  const governance::CompiledGrant compiled(document, *grant, domain);
  const auto verdict = compiled.judge(action, request);
  const auto what = verdict.rule == nullptr ? "no rule matches; the default"
                    : verdict.allowed       ? "an allow_rule"
                                            : "a deny_rule";
  return Answer{verdict.allowed, fmt::format("{} of grant \"{}\"", what, grant->name), file,
                verdict.line(*grant)};
}

// Documents give a revoked participant nothing, whatever they say: its peers refuse it. The CA's
// own list counts where it lies beside the participant.
std::optional<Answer> by_revocation(const pki::ParticipantFolder& folder) {
  const auto certificate = read_certificate(folder.certificate);
  const auto cas = read_certificates(folder.identity_ca);
  const auto own = read_crl(folder.crl);
  if (!certificate || !cas || !own) return std::nullopt;  // doctor's business
  std::vector<pki::Crl> lists;
  if (*own) lists.push_back(**own);
  const auto newer = governance::doctor::newer_ca_list(folder, *cas, lists);
  const auto answer = [&](const pki::Crl& list, const fs::path& file) {
    return Answer{
        false,
        fmt::format("the certificate is revoked by list {} of the CA", list.number().value_or(0)),
        file, 0};
  };
  if (newer && governance::doctor::names(newer->list, *certificate))
    return answer(newer->list, newer->file);
  if (*own && governance::doctor::names(**own, *certificate)) return answer(**own, folder.crl);
  return std::nullopt;
}

Result<Report> can(const Arguments& arguments, const Context& context) {
  const auto folder = pki::participant_folder(arguments.text("SUBJECT"));
  const auto topic = arguments.text("TOPIC");
  const auto action = DDSSEC_TRY(action_of(arguments));
  const auto domain = DDSSEC_TRY(domain_of(arguments));
  const auto& names = arguments.all("--partition");
  const std::vector<std::string_view> partitions(names.begin(), names.end());
  const auto now = context.clock.now();
  auto answer = by_revocation(folder);
  if (!answer) answer = DDSSEC_TRY(by_governance(folder, action, topic, domain, now));
  if (!answer)
    answer = DDSSEC_TRY(
        by_permissions(folder, action, {.topic = topic, .partitions = partitions}, domain, now));
  return Report{.exit = answer->allowed ? Exit::done : Exit::no,
                .text = fmt::format("{}: {} ({}{})\n", answer->allowed ? "allowed" : "denied",
                                    answer->because, answer->document.string(),
                                    answer->line > 0 ? fmt::format(":{}", answer->line) : ""),
                .result = {{"allowed", answer->allowed},
                           {"because", answer->because},
                           {"file", answer->document.string()},
                           {"line", answer->line}}};
}

}  // namespace

std::vector<Command> can_commands() {
  return {
      {.group = "",
       .name = "can",
       .summary = "Says whether a participant may use a topic, and which line decides; exit 1: no.",
       .positionals = {{"SUBJECT", "the participant's folder"},
                       {"ACTION", "publish or subscribe"},
                       {"TOPIC", "the topic's name"}},
       .options = {kDomain, repeated("--partition", "P", "a partition of the endpoint")},
       .examples = {"ddssec can talker publish rt/chatter"},
       .run = can}};
}

}  // namespace ddssec::cli
