// Checks whether Fast DDS would start with a profile, and with security.
#include <string>
#include <vector>

#include <fmt/format.h>

#include "governance/doctor/configuration_checks.hpp"
#include "governance/doctor/fastdds_elements.hpp"
#include "governance/xml.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr Outcomes kFastFails{.fastdds = Outcome::fail};
constexpr std::string_view kHint =
    "let the <participant> with is_default_profile=\"true\" have the properties that ddssec "
    "identity "
    "issue NAME --ca CA -o DIR writes; or move the file away, and the command writes it again";

// A property that switches one plugin on.
struct Plugin {
  std::string_view property;
  std::string_view value;
};
constexpr Plugin kPlugins[] = {
    {"dds.sec.auth.plugin", "builtin.PKI-DH"},
    {"dds.sec.access.plugin", "builtin.Access-Permissions"},
    {"dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC"},
};
constexpr std::string_view kDocuments[] = {
    "dds.sec.auth.builtin.PKI-DH.identity_ca",
    "dds.sec.auth.builtin.PKI-DH.identity_certificate",
    "dds.sec.auth.builtin.PKI-DH.private_key",
    "dds.sec.access.builtin.Access-Permissions.permissions_ca",
    "dds.sec.access.builtin.Access-Permissions.governance",
    "dds.sec.access.builtin.Access-Permissions.permissions",
};

template <class Each>
void each_child(XmlElement parent, std::string_view name, Each&& each) {
  if (!parent) return;
  for (auto child = parent.first_child(); child; child = child.next_sibling())
    if (child.name() == name) each(child);
}

XmlElement child_of(XmlElement parent, std::string_view name) {
  XmlElement out;
  each_child(parent, name, [&](XmlElement child) {
    if (!out) out = child;
  });
  return out;
}

// If several participants are marked as the default, the last one counts.
XmlElement default_participant(XmlElement root) {
  XmlElement out;
  const auto profiles = root.name() == "dds" ? child_of(root, "profiles") : root;
  if (!profiles || profiles.name() != "profiles") return out;
  each_child(profiles, "participant", [&](XmlElement participant) {
    const char* const is_default = participant.attribute("is_default_profile");
    if (is_default != nullptr && std::string_view(is_default) == "true") out = participant;
  });
  return out;
}

// True if some <participant> has is_default_profile. It may also be beside <profiles>.
bool has_default_participant(XmlElement parent) {
  for (auto child = parent.first_child(); child; child = child.next_sibling())
    if (child.name() == "participant"
            ? child.attribute("is_default_profile") != nullptr
            : child.name() == "profiles" && has_default_participant(child))
      return true;
  return false;
}

// Blanks around names and values are part of them.
ProfileProperties properties_of(XmlElement participant) {
  ProfileProperties out;
  const auto policy = child_of(child_of(participant, "rtps"), "propertiesPolicy");
  each_child(child_of(policy, "properties"), "property", [&](XmlElement property) {
    const auto text = [&](std::string_view name) {
      const auto element = child_of(property, name);
      return element ? element.raw_text().value_or("") : std::string();
    };
    out.emplace_back(text("name"), text("value"));
  });
  return out;
}

// The value of the last property with this name (measured).
const std::string* value_of(const ProfileProperties& all, std::string_view name) {
  const std::string* out = nullptr;
  for (const auto& [found, value] : all)
    if (found == name) out = &value;
  return out;
}

class Checks {
 public:
  Checks(const CheckedProfile& question, Diagnosis& out) : question_(question), out_(out) {}

  void run() {
    out_.pass(Rule::DOC101);
    out_.pass(Rule::DOC102);
    out_.pass(Rule::DOC108);
    const auto document = XmlDocument::parse(as_bytes(question_.text));
    if (!document) return report_unread(document.error());
    report_doubts(doubts_about_profiles(document->root(), question_.version));
    const auto participant = default_participant(document->root());
    if (!participant)
      return report_unsecured(
          0, "has no <participant> with is_default_profile=\"true\" in <profiles>");
    const auto properties = properties_of(participant);
    for (const auto& plugin : kPlugins)
      if (const auto wrong = wrong_in(properties, plugin); !wrong.empty())
        return report_without(plugin, participant.line(), wrong);
    for (const auto name : kDocuments)
      if (const auto* const value = value_of(properties, name); value == nullptr || value->empty())
        report(Rule::DOC102, participant.line(),
               fmt::format("names no {}, so that Fast DDS does not start", name));
  }

 private:
  void report(Rule rule, int line, std::string_view what) {
    out_.report(kFastFails, {.rule = rule,
                             .message = fmt::format("{} {}", question_.name, what),
                             .document = question_.document,
                             .line = line,
                             .hint = std::string(kHint)});
  }

  // "" if the plugin is switched on.
  static std::string wrong_in(const ProfileProperties& properties, const Plugin& plugin) {
    const auto* const value = value_of(properties, plugin.property);
    if (value == nullptr)
      return fmt::format("has no property {} in its default profile", plugin.property);
    if (*value == plugin.value) return {};
    return fmt::format("has the property {} = \"{}\", which must be \"{}\"", plugin.property,
                       *value, plugin.value);
  }

  void report_unsecured(int line, std::string_view what) {
    report(Rule::DOC101, line,
           fmt::format("{}: a Fast DDS process that starts with it runs without security", what));
  }

  // Measured: with authentication alone Fast DDS starts, and does not match a participant without
  // security.
  void report_without(const Plugin& plugin, int line, const std::string& what) {
    if (&plugin == kPlugins) return report_unsecured(line, what);
    out_.report({.fastdds = Outcome::unsafe},
                {.rule = Rule::DOC101,
                 .message = fmt::format("{} {}: a Fast DDS process that starts with it does not "
                                        "apply all of the documents that were judged",
                                        question_.name, what),
                 .document = question_.document,
                 .line = line,
                 .hint = std::string(kHint)});
  }

  // Fast DDS reads some documents that ddssec refuses, so only some errors mean that it reads
  // nothing.
  void report_unread(const Error& error) {
    const int line = error.details().line;
    const bool is_refused = error.code() == Code::xml_not_well_formed ||
                            error.code() == Code::xml_processing_instruction;
    if (is_refused)
      return report_unsecured(line, fmt::format("cannot be read ({})", error.message()));
    report_doubts({{fmt::format("cannot be judged: {}", error.message()), line}});
  }

  // Measured: Fast DDS ignores the whole file for one element or value that it does not accept, and
  // says so only in its log.
  void report_doubts(const std::vector<ConfiguredText>& doubts) {
    for (const auto& doubt : doubts)
      out_.report(kFastFails,
                  {.rule = Rule::DOC108,
                   .message = fmt::format(
                       "{} {}: it is not known that Fast DDS {} accepts this, and if it does not, "
                       "it ignores the file, and the process runs WITHOUT security",
                       question_.name, doubt.text, to_string(question_.version)),
                   .document = question_.document,
                   .line = doubt.line});
  }

  const CheckedProfile& question_;
  Diagnosis& out_;
};

}  // namespace

std::optional<ProfileProperties> properties_of_profile(std::string_view text) {
  const auto document = XmlDocument::parse(as_bytes(text));
  const auto participant = document ? default_participant(document->root()) : XmlElement();
  return participant ? std::optional(properties_of(participant)) : std::nullopt;
}

bool may_set_default_participant(std::string_view text) {
  const auto document = XmlDocument::parse(as_bytes(text));
  return !document || has_default_participant(document->root());
}

void diagnose_profile(const CheckedProfile& question, Diagnosis& out) {
  Checks(question, out).run();
}

}  // namespace ddssec::governance::doctor
