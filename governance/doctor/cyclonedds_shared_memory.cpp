#include "governance/doctor/cyclonedds_shared_memory.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::string_view kVariable = "CYCLONEDDS_URI";

// True if the governance promises anything about samples in the domain.
bool promises(const DomainRule& rule) {
  return is_protected(rule.rtps_protection_kind) ||
         std::ranges::any_of(rule.topic_rules, [](const TopicRule& topic) {
           return is_protected(topic.metadata_protection_kind) ||
                  is_protected(topic.data_protection_kind) || topic.enable_read_access_control ||
                  topic.enable_write_access_control;
         });
}

}  // namespace

std::string shared_memory_setting(std::string_view configuration) {
  const auto text = ascii_lower(without_comments(configuration));
  if (find_tag(text, "pubsubmessageexchange")) return "<PubSubMessageExchange>";
  for (const auto word : values_within(text, "sharedmemory", "enable"))
    if (word != "false") return fmt::format("<SharedMemory><Enable>{}", word.substr(0, 64));
  return {};
}

void diagnose_shared_memory(const LoadedFolder& folder,
                            const std::optional<std::string>& configuration,
                            const Settings& settings, Diagnosis& out) {
  if (!configuration || !folder.governance.model) return;
  const auto* const rule = folder.governance.model->find(settings.domain);
  if (rule == nullptr) return;
  const auto setting = shared_memory_setting(*configuration);
  if (setting.empty() || !promises(*rule)) return out.pass(Rule::DOC100);
  out.report({.cyclonedds = Outcome::unsafe, .ddssec = Outcome::late},
             {.rule = Rule::DOC100,
              .message = fmt::format(
                  "{} is set in {}: samples of topics that {} protects would lie in the clear in "
                  "shared memory; Cyclone DDS's own plugins are not asked, ours refuse the writers "
                  "and readers (shared_memory_bypasses_protection)",
                  setting, kVariable, folder.paths.governance.filename().string()),
              .document = folder.paths.governance});
}

}  // namespace ddssec::governance::doctor
