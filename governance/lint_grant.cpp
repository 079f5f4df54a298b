#include "governance/lint_grant.hpp"

#include <fmt/format.h>

#include "base/never_destroyed.hpp"

namespace ddssec::governance {

GrantPlace::GrantPlace(const Grant& grant, std::size_t number)
    : grant_(grant), path_(fmt::format("/dds/permissions/grant[{}]", number)) {
  std::array<std::size_t, 2> counts{};
  for (std::size_t i = 0; i < grant.rules.size(); ++i) {
    const auto& rule = grant.rules[i];
    rule_paths_.push_back(fmt::format("{}/{}[{}]", path_, rule.allow ? "allow_rule" : "deny_rule",
                                      ++counts[rule.allow ? 0 : 1]));
    for (const auto action : {0u, 1u})
      for (const auto& criteria : action == 0 ? rule.publish : rule.subscribe)
        for (const auto& topic : criteria.topics)
          entries_[action].push_back({&rule, i + 1, &criteria, &topic});
  }
}

Finding GrantPlace::about(Rule id, std::string message) const {
  return {.rule = id, .message = std::move(message), .line = grant_.line, .path = path_};
}

Finding GrantPlace::about(Rule id, const GrantEntry& entry, std::string message) const {
  return {.rule = id,
          .message = std::move(message),
          .line = entry.topic->line,
          .path = rule_path(entry.rule_number)};
}

Finding GrantPlace::about_rule(Rule id, std::size_t rule_number, std::string message) const {
  return {.rule = id,
          .message = std::move(message),
          .line = grant_.rules.at(rule_number - 1).line,
          .path = rule_path(rule_number)};
}

std::string rule_name(const GrantEntry& entry) {
  return fmt::format("{} {}", entry.rule->allow ? "allow_rule" : "deny_rule", entry.rule_number);
}

const std::vector<Text>& listed_partitions(const Criteria& criteria) {
  static const NeverDestroyed<std::vector<Text>> kNone;
  return criteria.partitions ? *criteria.partitions : *kNone;
}

std::vector<std::string_view> allowed_texts(const std::vector<GrantEntry>& entries) {
  std::vector<std::string_view> out;
  for (const auto& entry : entries)
    if (entry.rule->allow) out.emplace_back(entry.topic->text);
  return out;
}

}  // namespace ddssec::governance
