#include "governance/doctor/transport.hpp"

#include <fmt/format.h>

#include "base/text.hpp"

namespace ddssec::governance::doctor {

std::string tcp_setting(std::string_view configuration) {
  const auto text = ascii_lower(without_comments(configuration));
  for (const auto word : values_within(text, "tcp", "enable"))
    if (word != "false" && word != "default")
      return fmt::format("<TCP><Enable>{}", word.substr(0, 64));
  for (const auto word : values_within(text, "general", "transport"))
    if (word == "tcp" || word == "tcp6") return fmt::format("<Transport>{}", word);
  return {};
}

void diagnose_transport(const std::optional<std::string>& configuration, Diagnosis& out) {
  if (!configuration) return;
  const auto setting = tcp_setting(*configuration);
  if (setting.empty()) return out.pass(Rule::DOC106);
  out.report({}, {.rule = Rule::DOC106,
                  .message = fmt::format(
                      "{} is set in CYCLONEDDS_URI: one forged announcement can part two "
                      "participants until one of them starts again, since the datagrams by which "
                      "ddssec's plugins reconnect them are sent over UDP only "
                      "(transport_without_resets)",
                      setting),
                  .severity = Severity::warning});
}

}  // namespace ddssec::governance::doctor
