#include "governance/doctor/domain_tag.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr std::size_t kMaxShown = 64;

}  // namespace

// Names of elements may be in any letter case, but the tag itself may not.
std::string domain_tag_setting(std::string_view configuration) {
  const auto text = without_comments(configuration);
  const auto lower = ascii_lower(text);
  for (const auto word : values_within(lower, "discovery", "tag"))
    if (!word.empty() && word != "default")
      return text.substr(static_cast<std::size_t>(word.data() - lower.data()),
                         std::min(word.size(), kMaxShown));
  return {};
}

void diagnose_domain_tag(std::string_view configuration, const std::filesystem::path& document,
                         Diagnosis& out) {
  const auto tag = domain_tag_setting(configuration);
  if (tag.empty()) return;
  out.report({},
             {.rule = Rule::DOC114,
              .message = fmt::format(
                  "<Discovery><Tag> is \"{}\": rules for this tag do not count under Cyclone "
                  "DDS. With ddssec's plugins the participant authenticates no peer (1240); with "
                  "stock plugins, rules for no tag count",
                  tag),
              .document = document.string(),
              .severity = Severity::warning});
}

}  // namespace ddssec::governance::doctor
