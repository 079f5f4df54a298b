#include "governance/doctor/shared_memory.hpp"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "base/source.hpp"
#include "base/text.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::size_t kMostOctets = 1024 * 1024;
constexpr std::string_view kVariable = "CYCLONEDDS_URI";
constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::string_view kAfterName = " \t\r\n/>";

std::string without_comments(std::string_view text) {
  std::string out;
  for (;;) {
    const auto begin = text.find("<!--");
    out += text.substr(0, begin);
    if (begin == text.npos) return out;
    const auto end = text.find("-->", begin + 4);
    if (end == text.npos) return out;
    text.remove_prefix(end + 3);
  }
}

/// What stands after the start tag `name` (lower case), from `from` on; nothing if there is none.
std::optional<std::string_view> after_tag(std::string_view text, std::string_view name) {
  for (auto at = text.find('<'); at != text.npos; at = text.find('<', at + 1)) {
    const auto rest = text.substr(at + 1);
    if (!rest.starts_with(name)) continue;
    const auto after = rest.substr(name.size());
    if (after.empty() || kAfterName.find(after.front()) == kAfterName.npos) continue;
    const auto end = after.find('>');
    return end == after.npos ? std::string_view() : after.substr(end + 1);
  }
  return std::nullopt;
}

/// Whether governance promises anything about samples in the domain.
bool promises(const DomainRule& rule) {
  return is_protected(rule.rtps_protection_kind) ||
         std::ranges::any_of(rule.topic_rules, [](const TopicRule& topic) {
           return is_protected(topic.metadata_protection_kind) ||
                  is_protected(topic.data_protection_kind) || topic.enable_read_access_control ||
                  topic.enable_write_access_control;
         });
}

}  // namespace

std::optional<std::string> cyclonedds_configuration() {
  const char* const uri = std::getenv(kVariable.data());
  if (uri == nullptr) return std::nullopt;
  return cyclonedds_configuration(uri);
}

std::optional<std::string> cyclonedds_configuration(std::string_view uri) {
  std::string out;
  for (;;) {
    while (!uri.empty() && (uri.front() == ',' || kBlanks.find(uri.front()) != kBlanks.npos))
      uri.remove_prefix(1);
    if (uri.empty()) return out;
    if (uri.front() == '<') return out.append(uri);  // to the end: commas may be in it
    const auto name = uri.substr(0, uri.find(','));
    uri.remove_prefix(name.size());
    const auto file = name.starts_with("file:") ? std::string(name) : "file:" + std::string(name);
    const auto octets = ddssec::load(file, kVariable, kMostOctets);
    if (!octets) return std::nullopt;
    out.append(octets->begin(), octets->end()).push_back('\n');
  }
}

std::string shared_memory_setting(std::string_view configuration) {
  const auto text = ascii_lower(without_comments(configuration));
  if (after_tag(text, "pubsubmessageexchange")) return "<PubSubMessageExchange>";
  std::string_view rest = text;
  while (const auto inside = after_tag(rest, "sharedmemory")) {
    rest = *inside;
    const auto end = std::min(rest.find("</sharedmemory"), rest.find("<sharedmemory"));
    const auto value = after_tag(rest.substr(0, end), "enable");
    if (!value) continue;
    const auto word = trimmed(value->substr(0, value->find('<')), kBlanks);
    if (word != "false") return fmt::format("<SharedMemory><Enable>{}", word.substr(0, 64));
  }
  return {};
}

void check_shared_memory(const LoadedFolder& folder,
                         const std::optional<std::string>& configuration, const Settings& settings,
                         Diagnosis& out) {
  if (!configuration || !folder.governance.model) return;
  const auto* const rule = folder.governance.model->find(settings.domain);
  if (rule == nullptr) return;
  const auto setting = shared_memory_setting(*configuration);
  if (setting.empty() || !promises(*rule)) return out.pass(Rule::DOC100);
  out.report({.cyclonedds = Outcome::unsafe, .ours = Outcome::late},
             {.rule = Rule::DOC100,
              .message = fmt::format(
                  "{} is set in {}: samples of topics that {} protects would lie in the clear in "
                  "shared memory; Cyclone DDS's own plugins are not asked, ours refuse the writers "
                  "and readers (shared_memory_bypasses_protection)",
                  setting, kVariable, folder.paths.governance.filename().string()),
              .document = folder.paths.governance});
}

}  // namespace ddssec::governance::doctor
