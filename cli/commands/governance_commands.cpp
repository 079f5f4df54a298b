// governance new: a document from a profile and a few topic rules.
#include <algorithm>
#include <filesystem>
#include <optional>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/ca/governance_revision.hpp"
#include "cli/ca/new_document.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/frame/options.hpp"
#include "governance/lint.hpp"
#include "governance/profile.hpp"
#include "governance/read.hpp"
#include "governance/write.hpp"

namespace ddssec::cli {
namespace {

using governance::TopicRule;

std::unexpected<Error> topic_option_error(const std::string& text, std::string expected) {
  return fail(Code::usage,
              {.field = "--topic", .expected = std::move(expected), .found = '"' + text + '"'});
}

// A key of --topic, under its short name and under the document's name.
struct KindKey {
  std::string_view name, element;
  ProtectionKind TopicRule::*member;
};
struct FlagKey {
  std::string_view name, element;
  bool TopicRule::*member;
};
constexpr KindKey kKindKeys[] = {
    {"metadata", "metadata_protection_kind", &TopicRule::metadata_protection_kind},
    {"data", "data_protection_kind", &TopicRule::data_protection_kind}};
constexpr FlagKey kFlagKeys[] = {
    {"discovery", "enable_discovery_protection", &TopicRule::enable_discovery_protection},
    {"liveliness", "enable_liveliness_protection", &TopicRule::enable_liveliness_protection},
    {"read", "enable_read_access_control", &TopicRule::enable_read_access_control},
    {"write", "enable_write_access_control", &TopicRule::enable_write_access_control}};
constexpr std::string_view kKeys =
    "data=KIND, metadata=KIND, or discovery, liveliness, read, write =true or =false";

// Returns the key of that name or element, or nullptr.
template <std::size_t N, class Key>
const Key* find_key(const Key (&keys)[N], std::string_view name) {
  const auto found = std::ranges::find_if(
      keys, [&](const Key& key) { return key.name == name || key.element == name; });
  return found == std::end(keys) ? nullptr : found;
}

Status set_key(TopicRule& rule, const std::string& text, std::string_view pair) {
  const auto equals = pair.find('=');
  if (equals == pair.npos) return topic_option_error(text, "EXPR:" + std::string(kKeys));
  const auto name = pair.substr(0, equals);
  const std::string value(pair.substr(equals + 1));
  if (const auto* key = find_key(kKindKeys, name)) {
    const auto kind = protection_kind_from(ascii_upper(value));
    const bool is_data = key->member == &TopicRule::data_protection_kind;
    if (!kind || (is_data && is_origin_authenticated(*kind)))
      return topic_option_error(text, fmt::format("{}=NONE, SIGN{}", key->name,
                                                  is_data ? " or ENCRYPT"
                                                          : ", ENCRYPT or either with "
                                                            "_WITH_ORIGIN_AUTHENTICATION"));
    rule.*(key->member) = *kind;
  } else if (const auto* flag = find_key(kFlagKeys, name)) {
    if (value != "true" && value != "false")
      return topic_option_error(text, fmt::format("{}=true or {}=false", flag->name, flag->name));
    rule.*(flag->member) = value == "true";
  } else {
    return topic_option_error(text, std::string(kKeys));
  }
  return {};
}

// Reads EXPR:key=value,... where missing keys have the values of the profile. The last colon
// separates: an expression that contains colons needs one at its end if no keys follow.
Result<TopicRule> topic_rule_from(const std::string& text, governance::Profile profile) {
  const auto colon = std::min(text.rfind(':'), text.size());
  auto rule = governance::topic_rule_of(profile, text.substr(0, colon));
  if (rule.topic_expression.empty())
    return topic_option_error(text, "an expression before the colon");
  // No topic name contains '='. Between brackets it may be part of an expression.
  if (rule.topic_expression.contains('=') && !rule.topic_expression.contains('['))
    return topic_option_error(text,
                              "a colon behind the expression, such as rt/camera*:data=ENCRYPT");
  std::string_view rest = std::string_view(text).substr(std::min(colon + 1, text.size()));
  while (!rest.empty()) {
    const auto comma = std::min(rest.find(','), rest.size());
    DDSSEC_RETURN_IF_ERROR(set_key(rule, text, rest.substr(0, comma)));
    rest.remove_prefix(std::min(comma + 1, rest.size()));
  }
  return rule;
}

// The protection of messages that no participant's own key protects.
Result<ProtectionKind> pre_shared_key_kind(const Arguments& arguments) {
  const auto text = arguments.text("--pre-shared-key");
  const auto kind = protection_kind_from(ascii_upper(text));
  if (kind && !is_origin_authenticated(*kind)) return *kind;
  return fail(Code::usage, {.field = "--pre-shared-key",
                            .expected = "NONE, SIGN or ENCRYPT",
                            .found = '"' + text + '"'});
}

// A topic without a rule is refused, so the profile's rule for all topics comes last.
Result<governance::Governance> document_from(const Arguments& arguments) {
  DDSSEC_ASSIGN_OR_RETURN(const auto profile, profile_option(arguments));
  DDSSEC_ASSIGN_OR_RETURN(auto ranges, domain_ranges(arguments, "--domain"));
  auto rule = governance::domain_rule_of(profile, std::move(ranges));
  DDSSEC_ASSIGN_OR_RETURN(rule.rtps_psk_protection_kind, pre_shared_key_kind(arguments));
  rule.enable_key_revision = arguments.has("--key-revision");
  for (const auto& text : arguments.all("--topic")) {
    DDSSEC_ASSIGN_OR_RETURN(auto topic_rule, topic_rule_from(text, profile));
    rule.topic_rules.push_back(std::move(topic_rule));
  }
  if (rule.topic_rules.empty() || rule.topic_rules.back().topic_expression != "*")
    rule.topic_rules.push_back(governance::topic_rule_of(profile, "*"));
  governance::Governance out;
  out.domain_rules.push_back(std::move(rule));
  return out;
}

struct NewGovernance {
  std::filesystem::path file;
  std::string profile;
  std::size_t topic_rules;
  std::optional<std::size_t> revision = {};
  std::vector<WrittenFile> files = {};  // all files that were written

  static constexpr auto fields() {
    using Self = NewGovernance;
    return std::tuple(
        field<&Self::file>(), field<&Self::profile>({.words = "open|balanced|strict"}),
        field<&Self::topic_rules>({"how many"}),
        field<&Self::revision>({.note = "with `--sign`", .def = "revision", .omits_empty = true}));
  }
  std::string text() const {
    std::string out;
    for (const auto& one : files) out += (out.empty() ? "" : "\n") + one.path;
    return out + (revision ? fmt::format("  revision {}\n", *revision) : "\n");
  }
};

Result<Answer<NewGovernance>> governance_new(const Arguments& arguments, const Context& context) {
  DDSSEC_ASSIGN_OR_RETURN(const auto governance_document, document_from(arguments));
  const auto xml = to_xml(governance_document);
  // The document is parsed, because the arguments may contain something that no document can.
  DDSSEC_ASSIGN_OR_RETURN(const auto document, governance::read_governance(as_bytes(xml)));
  Answer<NewGovernance> out{};
  auto& report = out.report;
  add_findings(report, lint(document), arguments.text("-o"));
  if (report.exit != Exit::done) {
    report.text = "not written: the rules contradict one another\n";
    out.has_result = false;
    return out;
  }
  DDSSEC_ASSIGN_OR_RETURN(report.files_written, write_document(xml, arguments, context, &document));
  out.result = {.file = report.files_written.front().path,
                .profile = arguments.text("--profile"),
                .topic_rules = document.domain_rules[0].topic_rules.size(),
                .files = report.files_written};
  if (const auto revision = revision_of(report.files_written.back().path); revision != 0)
    out.result.revision = revision;
  return out;
}

}  // namespace

std::vector<Command> governance_commands() {
  return {
      {.group = "governance",
       .name = "new",
       .summary = "Writes a governance document: a profile, and other values for some topics.",
       .positionals = {},
       .options = {{.name = "-o", .value = "FILE", .summary = "the new document", .required = true},
                   kDomains,
                   {"--profile", "NAME", "open, balanced or strict", "strict"},
                   {"--pre-shared-key", "KIND",
                    "NONE, SIGN or ENCRYPT what is said before participants are authenticated; "
                    "embedded participants of ddssec only",
                    "NONE"},
                   {"--key-revision", "",
                    "new keys for the others when a participant is no longer trusted; embedded "
                    "participants of ddssec only"},
                   repeated("--topic", "EXPR:KEY=VALUE,...",
                            "a rule for some topics, before the one for all others"),
                   kReplace,
                   kSign,
                   kSigningCa,
                   kNoRevision,
                   kPassphraseFile,
                   kPassphraseEnv,
                   kInsecureKeyMode},
       .examples = {"ddssec governance new --domain 0 -o governance.xml",
                    "ddssec governance new --topic 'rt/camera*:data=NONE' --sign --ca ca -o "
                    "governance.xml"},
       .run = governance_new}};
}

}  // namespace ddssec::cli
