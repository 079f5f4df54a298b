// Step five: which party may write and read which topic, according to which party.
#include <algorithm>
#include <ranges>

#include <fmt/format.h>

#include "governance/decision.hpp"
#include "governance/doctor/checks.hpp"
#include "governance/doctor/measured_outcomes.hpp"
#include "governance/doctor/meeting_steps.hpp"
#include "governance/doctor/product_decision.hpp"
#include "governance/grant.hpp"
#include "governance/refusal_advice.hpp"
#include "governance/topic_sets.hpp"

namespace ddssec::governance::doctor {
namespace {

std::string text(bool value) { return value ? "true" : "false"; }
std::string text(ProtectionKind value) { return std::string(to_string(value)); }

// Compares one element of two rules.
template <class Rules>
class Comparison {
 public:
  Comparison(const Rules& a, const Rules& b) : a_(a), b_(b) {}
  template <class T>
  Comparison& element(std::string_view name, T Rules::*member) {
    if (a_.*member != b_.*member)
      found_.push_back(
          {std::string(name), {text(a_.*member), text(b_.*member)}, {a_.line, b_.line}});
    return *this;
  }
  std::vector<Difference> found() { return std::move(found_); }

 private:
  const Rules& a_;
  const Rules& b_;
  std::vector<Difference> found_;
};

const TopicRule* topic_rule(const MeetingScene& scene, int index, std::string_view topic) {
  const auto* domain = scene.out.rules[index];
  return domain == nullptr ? nullptr : topic_rule_as(scene.party(index).product, *domain, topic);
}

std::string matching_expression(Product product, const Criteria& criteria, std::string_view topic) {
  const auto found = std::ranges::find_if(
      criteria.topics, [&](const Text& text) { return matches_as(product, text, topic); });
  return found == criteria.topics.end() ? "" : found->text;
}

// One question about a topic: does `judge` allow it to `about`?
struct Question {
  int judge;
  int about;
  Action action;
  const std::string& topic;
};

// " in partition "a""; empty if no partition was asked for.
std::string in_partitions(const MeetingScene& scene) {
  std::string out;
  for (const auto& name : scene.settings.partitions)
    out += fmt::format("{}\"{}\"", out.empty() ? "" : ", ", name);
  if (out.empty()) return out;
  return (scene.settings.partitions.size() == 1 ? " in partition " : " in partitions ") + out;
}

PartyDecision by_grant(const MeetingScene& scene, const Question& question) {
  const auto& folder = scene.folder(question.about);
  PartyDecision out{.judge = question.judge, .about = question.about};
  out.operation = to_string(question.action);
  out.document = folder.paths.permissions.string();
  const auto* compiled = scene.grants[question.about].get();
  if (compiled == nullptr) {
    out.reason = "no valid grant";
    return out;
  }
  const auto& grant = compiled->grant();
  const auto& asked = scene.settings.partitions;
  const std::vector<std::string_view> partitions(asked.begin(), asked.end());
  const Request request{.topic = question.topic, .partitions = partitions};
  const auto judge = question.judge == question.about ? judge_local_as : judge_as;
  const auto decision = judge(scene.party(question.judge).product, *compiled, scene.settings.domain,
                              question.action, request);
  const auto advice =
      scene.named ? advice_on(*compiled, question.action, request, decision) : RefusalAdvice();
  out.hint = advice.hint;
  out.grant = grant.name;
  out.line = decision.line(grant);
  out.ok = decision.allowed;
  if (decision.rule == nullptr) {
    out.reason =
        fmt::format("no {} rule of grant \"{}\" matches{}, default {}", out.operation, grant.name,
                    in_partitions(scene), grant.default_allow ? "ALLOW" : "DENY");
    if (!advice.because.empty()) out.reason += "; " + advice.because;
    return out;
  }
  out.rule = static_cast<int>(decision.rule - grant.rules.data()) + 1;
  if (decision.criteria != nullptr)
    out.expression = matching_expression(scene.party(question.judge).product, *decision.criteria,
                                         question.topic);
  out.is_allow_rule = decision.rule->allow;
  out.reason = fmt::format("grant \"{}\" rule {} ({}) {} \"{}\"", grant.name, out.rule,
                           out.is_allow_rule ? "allow" : "deny", out.operation, out.expression);
  if (out.is_allow_rule && !out.ok)
    out.reason +=
        fmt::format(" does not hold{}, and Fast DDS looks no further", in_partitions(scene));
  return out;
}

// The judge's governance decides whether permissions are checked at all.
PartyDecision judge(const MeetingScene& scene, const Question& question) {
  const auto* rule = topic_rule(scene, question.judge, question.topic);
  PartyDecision out{.judge = question.judge, .about = question.about};
  out.operation = to_string(question.action);
  out.document = scene.folder(question.judge).paths.governance.string();
  if (rule == nullptr) {
    out.reason = "no <topic_rule> matches the topic";
    out.line =
        scene.out.rules[question.judge] != nullptr ? scene.out.rules[question.judge]->line : 0;
    return out;
  }
  const bool controlled = question.action == Action::publish ? rule->enable_write_access_control
                                                             : rule->enable_read_access_control;
  if (controlled) return by_grant(scene, question);
  out.ok = true;
  out.line = rule->line;
  out.reason = fmt::format("<topic_rule> \"{}\" asks for no permission", rule->topic_expression);
  return out;
}

// Obstacle of a Fast DDS writer: it waits for crypto tokens that a Cyclone DDS reader does not send
// if only payloads are protected.
Obstacle unmatched_writer(const MeetingScene& scene, const TopicMeeting& topic, int writer) {
  if (topic.rules[0] == nullptr || topic.rules[1] == nullptr) return {};
  const auto& rule = *topic.rules[writer];
  const auto& self = scene.party(writer);
  const auto& other = scene.party(1 - writer);
  const bool payload_only =
      is_protected(rule.data_protection_kind) && !is_protected(rule.metadata_protection_kind);
  if (self.product != Product::fastdds || other.product != Product::cyclonedds || !payload_only)
    return {};
  return {.reason = fmt::format("data_protection_kind {} with metadata_protection_kind NONE: a {} "
                                "writer never matches a {} reader then",
                                to_string(rule.data_protection_kind), self.product_name(),
                                other.product_name()),
          .document = scene.folder(1).paths.governance.string(),
          .line = topic.rules[1]->line};
}

// Cyclone DDS 0.10 refuses to create a topic by the first rule that names it in either direction.
// It does not check if either access is free (DDS-Security 1.1 table 63).
Obstacle refused_topic(const MeetingScene& scene, const TopicMeeting& topic, int index) {
  const auto& party = scene.party(index);
  const auto* governance = topic.rules[index];
  const auto* compiled = scene.grants[index].get();
  const bool asks = party.product == Product::cyclonedds && governance != nullptr &&
                    compiled != nullptr && governance->enable_read_access_control &&
                    governance->enable_write_access_control &&
                    measured(Variant::grant_deny_one_way, party.lineup).cyclonedds != Outcome::ok;
  if (!asks) return {};
  const auto& grant = compiled->grant();
  const auto* rule = first_rule_naming(grant, scene.settings.domain, topic.topic);
  if (rule == nullptr || rule->allow) return {};
  return {.reason = fmt::format("{} at {} refuses to create the topic: the first rule of grant "
                                "\"{}\" that names it, in whatever direction, is a deny_rule",
                                party.product_name(), party.name, grant.name),
          .rule = Rule::DOC053,
          .document = party.folder.paths.permissions.string(),
          .line = rule->line};
}

bool is_partition_expression(const std::string& partition) {
  return partition.find_first_of("*?") != partition.npos;
}

// A name matches an expression, but an expression never matches another expression (DDS 1.4,
// 2.2.3.13). Fast DDS uses one text as an expression and the other one as a name. The two are equal
// here, so with Fast DDS they may match (measured with 2.9.1).
Obstacle expressions_only(const MeetingScene& scene) {
  const auto& asked = scene.settings.partitions;
  if (asked.empty() || !std::ranges::all_of(asked, is_partition_expression)) return {};
  const auto is_fastdds = [&](int i) { return scene.party(i).product == Product::fastdds; };
  const auto matches_itself = [](const std::string& partition) {
    return matches_as(Product::fastdds, {.text = partition}, partition);
  };
  if (std::ranges::all_of(kBoth, is_fastdds) && std::ranges::any_of(asked, matches_itself))
    return {};
  return {.reason = fmt::format("both are{}: two partition expressions never match each other, "
                                "whatever is allowed",
                                in_partitions(scene)),
          .document = scene.folder(0).paths.permissions.string(),
          .hint = "let one side name a partition without * and ?"};
}

// Fast DDS also takes a text with brackets for an expression. It need not match its own text: [AB]
// does not (measured with 2.9.1 on both sides). Other products take brackets in a partition
// literally.
Obstacle unequal_to_itself(const MeetingScene& scene) {
  const auto& asked = scene.settings.partitions;
  const bool is_read_by_fastdds =
      std::ranges::any_of(kBoth, [&](int i) { return scene.party(i).product == Product::fastdds; });
  const bool any = std::ranges::any_of(asked, [](const std::string& partition) {
    return matches_as(Product::fastdds, {.text = partition}, partition);
  });
  if (asked.empty() || !is_read_by_fastdds || any) return {};
  return {.reason = fmt::format("both are{}: Fast DDS reads that as an expression, which does not "
                                "match its own text",
                                in_partitions(scene)),
          .document = scene.folder(0).paths.permissions.string(),
          .hint = "name a partition without brackets and backslashes"};
}

Obstacle obstacle_between(const MeetingScene& scene, const TopicMeeting& topic, int writer) {
  if (auto found = expressions_only(scene); !found.reason.empty()) return found;
  if (auto found = unequal_to_itself(scene); !found.reason.empty()) return found;
  if (auto found = unmatched_writer(scene, topic, writer); !found.reason.empty()) return found;
  if (auto found = refused_topic(scene, topic, writer); !found.reason.empty()) return found;
  return refused_topic(scene, topic, 1 - writer);
}

TopicDirection predict_direction(const MeetingScene& scene, const TopicMeeting& topic, int writer) {
  TopicDirection out{.writer = writer};
  const int reader = 1 - writer;
  for (const auto& question : {Question{writer, writer, Action::publish, topic.topic},
                               Question{reader, writer, Action::publish, topic.topic},
                               Question{reader, reader, Action::subscribe, topic.topic},
                               Question{writer, reader, Action::subscribe, topic.topic}})
    out.steps.push_back(judge(scene, question));
  if (topic.rules[0] != nullptr && topic.rules[1] != nullptr)
    out.differences = differences(*topic.rules[0], *topic.rules[1]);
  out.obstacle = obstacle_between(scene, topic, writer);
  out.ok = scene.out.joined() && std::ranges::all_of(out.steps, &PartyDecision::ok) &&
           out.differences.empty() && out.obstacle.reason.empty();
  return out;
}

bool is_permitted(const TopicDirection& direction) {
  return std::ranges::all_of(direction.steps, &PartyDecision::ok);
}

// True if it matters that this direction is refused. If the permissions allow the other one and
// neither was requested, they are probably meant that way: something else separates the two then.
bool is_missed(const MeetingScene& scene, const TopicMeeting& topic,
               const TopicDirection& direction) {
  const auto& asked = scene.settings.writes;
  if (direction.ok) return false;
  return asked[0] || asked[1] ? asked[direction.writer]
                              : std::ranges::none_of(topic.directions, is_permitted);
}

void report_refusals(const MeetingScene& scene, const TopicMeeting& topic) {
  if (!scene.out.joined()) return;
  for (const auto& direction : topic.directions)
    for (const auto& step : direction.steps) {
      if (!is_missed(scene, topic, direction)) break;
      if (step.ok || step.judge != step.about) continue;
      scene.out.findings.push_back(
          {.rule = Rule::DOC086,
           .message = fmt::format("{} may not {} \"{}\": {}", scene.party(step.about).name,
                                  step.operation == "publish" ? "publish" : "subscribe to",
                                  topic.topic, step.reason),
           .document = step.document,
           .line = step.line,
           .hint = step.hint.empty() ? remedy_of_ros(scene.folder(step.about)) : step.hint});
    }
}

// The partitions in which a participant may use a topic, as its grant lists them.
std::vector<std::string> partitions_of(const CompiledGrant& grant, Action action,
                                       std::string_view topic) {
  std::vector<std::string> out;
  for (const auto* criteria : grant.allowed(action)) {
    if (!criteria->partitions || matching_expression(Product::ddssec, *criteria, topic).empty())
      continue;
    for (const auto& text : *criteria->partitions)
      if (!text.text.empty()) out.push_back(text.text);
  }
  return out;
}

// Both parties may use the topic without partitions, so it counts as working. The note is added
// once.
void note_partitions(const MeetingScene& scene, const TopicMeeting& topic) {
  const bool is_said =
      std::ranges::find(scene.out.notes, Rule::DOC099, &Finding::rule) != scene.out.notes.end();
  if (is_said || !scene.settings.partitions.empty()) return;
  for (const auto& direction : topic.directions) {
    const int writer = direction.writer;
    const int reader = 1 - writer;
    const bool asks = direction.ok && topic.rules[writer]->enable_write_access_control &&
                      topic.rules[writer]->enable_read_access_control;
    if (!asks || scene.grants[writer] == nullptr || scene.grants[reader] == nullptr) continue;
    const std::vector<std::string> partitions[] = {
        partitions_of(*scene.grants[writer], Action::publish, topic.topic),
        partitions_of(*scene.grants[reader], Action::subscribe, topic.topic)};
    if (partitions[0].empty() == partitions[1].empty()) continue;
    const int with = partitions[0].empty() ? reader : writer;
    const auto& one = partitions[0].empty() ? partitions[1].front() : partitions[0].front();
    const auto& expression = direction.steps[with == writer ? 2 : 0].expression;
    return scene.out.notes.push_back(
        {.rule = Rule::DOC099,
         .message =
             fmt::format("topics \"{}\": {} may use them only without a partition, {} in "
                         "\"{}\" too: in a partition they do not work",
                         expression, scene.party(1 - with).name, scene.party(with).name, one),
         .document = scene.folder(1 - with).paths.permissions.string()});
  }
}

// If the topic is an example of an expression, its name is made up.
std::string subject_of(const TopicMeeting& topic) {
  return topic.expression.empty()
             ? fmt::format("topic \"{}\"", topic.topic)
             : fmt::format("topics \"{}\" (e.g. \"{}\")", topic.expression, topic.topic);
}

std::string example_of_rule(const TopicMeeting& topic) {
  const auto& expression = topic.rules[1]->topic_expression;
  if (expression == topic.topic) return fmt::format("topic \"{}\"", topic.topic);
  return fmt::format("topics under the <topic_rule> \"{}\", such as \"{}\"", expression,
                     topic.topic);
}

// All topics under the same two rules have the same difference, so it is reported once.
void report_differences(const MeetingScene& scene, const TopicMeeting& topic) {
  for (const auto& difference : topic.directions[0].differences) {
    const auto message = sentence(scene, difference);
    const bool said = std::ranges::any_of(scene.out.findings, [&](const Finding& finding) {
      return finding.rule == Rule::DOC084 && finding.message.ends_with(message);
    });
    if (said) continue;
    scene.out.findings.push_back({.rule = Rule::DOC084,
                                  .message = fmt::format("{}: {}", example_of_rule(topic), message),
                                  .document = scene.folder(1).paths.governance.string(),
                                  .line = difference.lines[1]});
  }
}

// An obstacle of a topic that the permissions refuse anyway is not reported. Each message is
// reported once.
void report_obstacles(const MeetingScene& scene, const TopicMeeting& topic) {
  for (const auto& direction : topic.directions) {
    const auto& obstacle = direction.obstacle;
    if (obstacle.reason.empty() || !is_permitted(direction)) continue;
    auto message = fmt::format("{}: {}", subject_of(topic), obstacle.reason);
    if (std::ranges::find(scene.out.findings, message, &Finding::message) ==
        scene.out.findings.end())
      scene.out.findings.push_back({.rule = obstacle.rule,
                                    .message = std::move(message),
                                    .document = obstacle.document,
                                    .line = obstacle.line,
                                    .hint = obstacle.hint});
  }
}

// Adds a note for each topic rule once. It is only a note, because the environment of such a
// participant is not known here.
void note_unguarded(const MeetingScene& scene, const TopicMeeting& topic) {
  for (const int i : kBoth) {
    const auto* rule = topic.rules[i];
    if (rule == nullptr || scene.party(i).product != Product::ddssec) continue;
    const bool controlled = rule->enable_read_access_control || rule->enable_write_access_control;
    if (!controlled || is_protected(rule->metadata_protection_kind) ||
        is_protected(rule->data_protection_kind))
      continue;
    const auto document = scene.folder(i).paths.governance.string();
    const bool said = std::ranges::any_of(scene.out.notes, [&](const Finding& note) {
      return note.rule == Rule::GOV043 && note.document == document && note.line == rule->line;
    });
    if (said) continue;
    scene.out.notes.push_back(
        {.rule = Rule::GOV043,
         .message =
             fmt::format("{}: access is controlled and nothing protects it; in a Cyclone DDS "
                         "process ddssec's plugins refuse to make such an endpoint (1612)",
                         subject_of(topic)),
         .document = document,
         .line = rule->line});
  }
}

// Adds the topic expressions in a participant's documents.
void add_expressions(const MeetingScene& scene, int index, std::vector<RankedExpression>& out) {
  const auto add = [&](std::string_view expression) {
    out.push_back({expression, static_cast<std::uint32_t>(out.size()), 0});
  };
  if (const auto* rule = scene.out.rules[index])
    for (const auto& topic : rule->topic_rules) add(topic.topic_expression);
  if (scene.grants[index] == nullptr) return;
  for (const auto& rule : scene.grants[index]->grant().rules)
    for (const auto* list : {&rule.publish, &rule.subscribe})
      for (const auto& criteria : *list)
        for (const auto& topic : criteria.topics) add(topic.text);
}

// The number of characters that an expression fixes.
std::size_t fixed_characters(std::string_view expression) {
  const Pattern pattern(expression);
  return static_cast<std::size_t>(
      std::ranges::count(pattern.steps(), Pattern::Kind::character, &Pattern::Step::kind));
}

// The expression that is most specific about the atom's names; empty if one of them is the name
// itself. In `expressions` each has a list of its own.
std::string narrowest(const std::vector<RankedExpression>& expressions, const NameAtom& atom) {
  std::string_view out;
  for (const auto& match : atom.matches) {
    const auto expression = expressions[match.list].expression;
    if (Pattern(expression).is_literal()) return {};
    if (out.empty() || fixed_characters(expression) > fixed_characters(out)) out = expression;
  }
  return std::string(out);
}

bool is_allowed_for_either(const MeetingScene& scene, const std::string& topic) {
  for (const int i : kBoth)
    for (const auto action : {Action::publish, Action::subscribe})
      if (judge(scene, {i, i, action, topic}).ok) return true;
  return false;
}

}  // namespace

std::vector<Difference> differences(const DomainRule& a, const DomainRule& b) {
  return Comparison<DomainRule>(a, b)
      .element("discovery_protection_kind", &DomainRule::discovery_protection_kind)
      .element("liveliness_protection_kind", &DomainRule::liveliness_protection_kind)
      .element("rtps_protection_kind", &DomainRule::rtps_protection_kind)
      .element("rtps_psk_protection_kind", &DomainRule::rtps_psk_protection_kind)
      .element("enable_key_revision", &DomainRule::enable_key_revision)
      .found();
}

std::vector<Difference> differences(const TopicRule& a, const TopicRule& b) {
  return Comparison<TopicRule>(a, b)
      .element("enable_discovery_protection", &TopicRule::enable_discovery_protection)
      .element("enable_liveliness_protection", &TopicRule::enable_liveliness_protection)
      .element("enable_read_access_control", &TopicRule::enable_read_access_control)
      .element("enable_write_access_control", &TopicRule::enable_write_access_control)
      .element("metadata_protection_kind", &TopicRule::metadata_protection_kind)
      .element("data_protection_kind", &TopicRule::data_protection_kind)
      .found();
}

std::string sentence(const MeetingScene& scene, const Difference& difference) {
  const auto side = [&](int i) {
    return fmt::format("{} at {} ({}:{})", difference.values[i], scene.party(i).name,
                       scene.folder(i).paths.governance.filename().string(), difference.lines[i]);
  };
  return fmt::format("<{}> is {} and {}", difference.element, side(0), side(1));
}

std::vector<TopicOfInterest> topics_of_interest(const MeetingScene& scene) {
  std::vector<RankedExpression> expressions;
  for (const int i : kBoth) add_expressions(scene, i, expressions);
  const auto found = find_name_atoms(expressions);
  scene.out.topics_complete = found.is_complete;
  std::vector<TopicOfInterest> out;
  // If the search was stopped early, there may be many atoms, most of them useless.
  constexpr std::size_t kMaxOfMany = 2'000;
  const auto most = found.is_complete ? found.atoms.size() : kMaxOfMany;
  for (const auto& atom : found.atoms | std::views::take(most)) {
    if (!is_allowed_for_either(scene, atom.witness)) continue;
    if (out.size() == kMaxTopics) {
      scene.out.topics_complete = false;
      break;
    }
    out.push_back({atom.witness, narrowest(expressions, atom)});
  }
  return out;
}

void predict_topic(const MeetingScene& scene, const TopicOfInterest& topic) {
  TopicMeeting out{
      .topic = topic.name, .expression = topic.expression, .directions = {}, .rules = {}};
  for (const int i : kBoth) out.rules[i] = topic_rule(scene, i, topic.name);
  for (const int i : kBoth) out.directions[i] = predict_direction(scene, out, i);
  // Differences come first, because they separate the two in both directions.
  report_differences(scene, out);
  if (scene.named) report_refusals(scene, out);
  report_obstacles(scene, out);
  note_unguarded(scene, out);
  note_partitions(scene, out);
  scene.out.topics.push_back(std::move(out));
}

}  // namespace ddssec::governance::doctor
