#include "cli/diff/governance_diff_report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/diff/diff_words.hpp"
#include "plugins/access_control/protection.hpp"

namespace ddssec::cli {
namespace {

using governance::ChangeClass;
using governance::GovernanceChange;
using governance::Interop;

// Every change that is not harmless is in upper case.
std::string class_word(ChangeClass change) {
  const auto word = governance::to_string(change);
  return change == ChangeClass::neutral ? std::string(word) : ascii_upper(word);
}

std::string where(const GovernanceChange& change) {
  if (!change.is_about_topics)
    return change.element.element == "domain_rule" ? "everything" : "all topics";
  return topics_text(change.topics, change.witness);
}

// For a change of a whole domain: an example of the topics that it affects, if these are only some.
std::string of_which(const GovernanceChange& change, governance::ProtectionProperty property) {
  const auto found =
      std::ranges::find(change.of_some, property, &governance::PropertyOfSome::property);
  return found == change.of_some.end()
             ? std::string()
             : fmt::format(" (of some topics, such as {})", name_text(found->witness));
}

// The consequence of a change, if the properties do not show it. `others_lose` is true if other
// changes remove protection, perhaps for the same topics.
std::string_view consequence(const GovernanceChange& change, bool others_lose) {
  const bool wider = change.element.change == ChangeClass::wider;
  if (change.element.element == "domain_rule")
    return wider ? "now participants can be made there" : "now no participant can be made there";
  if (change.element.element == "topic_rule")
    return wider ? "now the topics can be used by insiders" : "now no endpoint can be made";
  if (change.element.element.starts_with("allowed_crypto_algorithms"))
    return change.element.change == ChangeClass::stronger
               ? "participants with other algorithms no longer join"
               : "now participants with other algorithms join";
  if (change.element.change == ChangeClass::weaker && others_lose)
    return "by itself it takes no protection away; the other lines say what is no longer protected";
  if (change.element.change == ChangeClass::weaker)
    return "what another element protects for the same topics stays protected";
  return {};
}

std::string to_text(const GovernanceChange& change, bool others_lose) {
  const auto heading = fmt::format("  {:<8} {:<7}", class_word(change.element.change),
                                   change.element.interop == Interop::none ? "" : "breaks");
  auto text = wrapped(heading, {where(change),
                                fmt::format("{} {} -> {}", change.element.element,
                                            name_text(change.element.old_value),
                                            name_text(change.element.new_value)),
                                lines_text(change.old_line(), change.new_line())});
  const std::string indentation(heading.size(), ' ');
  const auto below = [&](const std::string& line) { text += wrapped(indentation, {line}); };
  for (const auto property : governance::listed(change.lost))
    below(fmt::format("now {}{}", governance::without(property), of_which(change, property)));
  for (const auto property : governance::listed(change.gained))
    below(
        fmt::format("no longer: {}{}", governance::without(property), of_which(change, property)));
  const auto also = consequence(change, others_lose);
  if (change.lost.none() && change.gained.none() && !also.empty()) below(std::string(also));
  return text;
}

std::string to_text(const governance::RewrittenRules& rules, bool only_listed) {
  const auto only_order = rules.only_old.empty() && rules.only_new.empty();
  std::vector<std::string> parts = {only_order ? "rules stand in another order:" : ""};
  if (!rules.only_old.empty()) parts.push_back(names_text(rules.only_old) + " left,");
  if (!rules.only_new.empty()) parts.push_back(names_text(rules.only_new) + " came:");
  parts.push_back(only_listed ? "none of the listed topics is treated differently"
                              : "no name is treated differently");
  return wrapped(fmt::format("  {:<8} {:<7}", "neutral", ""), parts);
}

std::string verdict_text(const governance::GovernanceDiff& diff, bool is_phased) {
  auto verdict = ascii_upper(governance::to_string(diff.verdict)) + ';';
  if (diff.flag_day_domains.empty()) {
    return wrapped("verdict: ",
                   {verdict + (diff.unknown_domains.empty()
                                   ? " both files work together"
                                   : " whether both files work together is not known")});
  }
  const auto domains = domains_text(diff.flag_day_domains);
  if (is_phased && diff.parts_participants)
    return wrapped("verdict: ",
                   {verdict + " a participant that stays with the old file does not talk to those",
                    fmt::format("that have changed to the new one ({})", domains)}) +
           wrapped(
               "",
               {"put it into all folders within a minute: embedded participants change together,",
                "and no match ends; start all others again at that time"});
  if (is_phased)
    return wrapped("verdict: ",
                   {verdict + fmt::format(" on topics with a line \"breaks\" ({}),", domains),
                    "a participant that stays with the old file no longer matches those that have",
                    "changed to the new one; other topics work"}) +
           wrapped(
               "",
               {"put it into all folders within a minute: embedded participants change together,",
                "and no match ends; start others that use these topics again at that time"});
  if (!diff.parts_participants)
    return wrapped("verdict: ",
                   {verdict + fmt::format(" on topics with a line \"breaks\" ({}),", domains),
                    "endpoints with the old file do not match those with the new one;",
                    "other topics work"}) +
           wrapped("", {"deploy to all participants that use these topics at once,",
                        "or move gradually by way of a second domain or other topic names"});
  verdict += " participants still on the old file will not talk to those on the new one";
  const auto one_line = fmt::format("{} ({})", verdict, domains);
  constexpr std::size_t kFits = 91;
  const auto told = one_line.size() <= kFits ? std::vector{one_line}
                                             : std::vector{verdict, fmt::format("({})", domains)};
  return wrapped("verdict: ", told) +
         wrapped("", {fmt::format("deploy to all participants of {} at once,", domains),
                      "or move gradually by way of a second domain or other topic names"});
}

std::string to_text(const governance::GovernanceDiff& diff, bool only_listed) {
  std::string text, heading;
  const auto under = [&](std::string next) {
    if (next != heading) text += next + "\n";
    heading = std::move(next);
  };
  if (!diff.unknown_domains.empty()) {
    under(domains_text(diff.unknown_domains));
    text +=
        "  UNKNOWN  too many combinations of expressions to compare; --topics FILE compares\n"
        "           the topics in use\n";
  }
  const bool some_lose = std::ranges::any_of(
      diff.changes, [](const GovernanceChange& change) { return !change.lost.none(); });
  for (const auto& change : diff.changes) {
    under(scope_text(change.scope));
    text += to_text(change, some_lose);
  }
  for (const auto& rules : diff.rewritten) {
    under(scope_text(rules.scope));
    text += to_text(rules, only_listed);
  }
  if (!diff.complete) text += "more rules than are named here changed in the same ways\n";
  return text;
}

}  // namespace

std::optional<std::string> announced_mask(const GovernanceChange& change, bool is_new,
                                          bool is_plugin_mask) {
  const auto& domain = is_new ? change.new_domain : change.old_domain;
  const auto& topic = is_new ? change.new_topic : change.old_topic;
  if (change.is_about_topics ? !topic : !domain) return std::nullopt;
  const auto info = change.is_about_topics
                        ? spi::security_info(access_control::endpoint_attributes(*topic))
                        : spi::security_info(access_control::participant_attributes(*domain));
  return fmt::format("0x{:08x}", is_plugin_mask ? info.plugin_mask : info.mask);
}

std::vector<std::string_view> words_of(const governance::Properties& properties) {
  std::vector<std::string_view> out;
  for (const auto property : governance::listed(properties))
    out.push_back(governance::to_string(property));
  return out;
}

std::vector<ShownGovernanceChange> GovernanceComparison::changes() const {
  std::vector<ShownGovernanceChange> out;
  for (const auto& change : diff.changes) out.push_back({&change, &sides});
  return out;
}

std::string GovernanceComparison::text() const {
  return to_text(diff, only_listed) + interpretations_text(diff.interpretations) +
         signer_text(sides) + verdict_text(diff, live.is_phased) +
         (only_listed ? "only the topics of --topics were compared; for others the verdict says "
                        "nothing\n"
                      : "") +
         live.text;
}

}  // namespace ddssec::cli
