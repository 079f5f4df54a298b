#include "governance/refusal_advice.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include <fmt/format.h>

#include "base/text.hpp"
#include "governance/ros_node.hpp"

namespace ddssec::governance {
namespace {

constexpr std::size_t kMaxNameOctets = 128;  // the longest name that is compared with others
constexpr std::size_t kMaxNames = 1000;      // names that are compared
constexpr std::size_t kMaxShown = 4;         // partitions that a sentence shows

std::string cut_name(std::string_view text) {
  const bool is_long = text.size() > kMaxNameOctets;
  return fmt::format("\"{}{}\"", text.substr(0, kMaxNameOctets), is_long ? "..." : "");
}

template <class Texts>
std::string name_list(const Texts& texts) {
  std::string out;
  std::size_t count = 0;
  for (const auto& text : texts) {
    if (++count > kMaxShown) return out + ", ...";
    out += (count == 1 ? "" : ", ") + cut_name(text);
  }
  return out;
}

RefusalAdvice about_partitions(const Criteria& criteria, const Request& request) {
  const bool has_none = request.partitions.empty();
  const auto asked = has_none ? std::string() : name_list(request.partitions);
  return {.because = fmt::format("line {} allows the topic, but {}", criteria.line,
                                 partitions_of(criteria)),
          .hint = fmt::format("the topic is allowed, but not {}{}: add {} to <partitions> of the "
                              "rule (--partition of ddssec identity issue and ddssec permissions "
                              "new) and sign the permissions again, or change the endpoint's",
                              has_none ? "without a partition" : "in partition ", asked,
                              has_none ? "an empty one" : "it")};
}

RefusalAdvice about_data_tags(const Criteria& criteria) {
  return {.because =
              fmt::format("line {} allows the topic, but not with these data tags", criteria.line),
          .hint =
              "the topic is allowed, but not with these data tags: add them to <data_tags> of "
              "the rule and sign the permissions again"};
}

// ROS 2's topics have a prefix that their names in ROS do not show.
bool is_ros_name_of(std::string_view allowed, std::string_view topic) {
  if (topic.starts_with('/')) topic.remove_prefix(1);
  return !topic.empty() && allowed.starts_with("rt/") && allowed.substr(3) == topic;
}

// The largest number of edits that count as a typo. `length` is that of the name, or of an
// expression's longest part without a wildcard.
std::size_t max_edits(std::size_t length) { return length < 4 ? 0 : length < 7 ? 1 : 2; }

// The distance of two names; empty if they are too different to be a typo.
std::optional<std::size_t> distance(std::string_view allowed, std::string_view topic) {
  if (is_ros_name_of(allowed, topic) || is_ros_name_of(topic, allowed)) return 0;
  const auto lower = ascii_lower(allowed);
  const auto wanted = ascii_lower(topic);
  if (lower == wanted) return 0;
  const auto most = max_edits(topic.size());
  const auto [shorter, longer] = std::minmax({lower.size(), wanted.size()});
  if (longer - shorter > most) return std::nullopt;
  const auto out = edit_distance(lower, wanted);
  return out <= most ? std::optional(out) : std::nullopt;
}

// The length of the longest part without a wildcard. The prefix of ROS 2 is left out, because most
// names have it.
std::size_t longest_part(std::string_view expression) {
  std::size_t out = 0;
  if (expression.starts_with("rt/")) expression.remove_prefix(3);
  while (!expression.empty()) {
    const auto end = std::min(expression.find_first_of("*?"), expression.size());
    out = std::max(out, end);
    expression.remove_prefix(std::min(end + 1, expression.size()));
  }
  return out;
}

// The fewest edits of a name, as in edit_distance(), after which an expression of "*", "?" and
// letters matches it.
std::size_t edits_to_match(std::string_view expression, std::string_view name) {
  std::vector<std::size_t> earlier(name.size() + 1), before(name.size() + 1), now(name.size() + 1);
  std::iota(now.begin(), now.end(), std::size_t{0});
  for (std::size_t at = 0; at < expression.size(); ++at) {
    const char c = expression[at];
    earlier.swap(before);
    before.swap(now);
    now[0] = before[0] + (c == '*' ? 0 : 1);
    for (std::size_t i = 1; i <= name.size(); ++i) {
      const bool is_same = c == '?' || c == name[i - 1];
      now[i] = c == '*'
                   ? std::min(before[i], now[i - 1])
                   : std::min({before[i - 1] + (is_same ? 0 : 1), before[i] + 1, now[i - 1] + 1});
      if (at > 0 && i > 1 && c == name[i - 2] && expression[at - 1] == name[i - 1])
        now[i] = std::min(now[i], earlier[i - 2] + 1);
    }
  }
  return now.back();
}

// As distance(), for an expression. The program's name is compared as it is and with the prefix of
// ROS 2.
std::optional<std::size_t> distance_to_expression(std::string_view allowed,
                                                  std::string_view topic) {
  const auto expression = ascii_lower(allowed);
  const auto wanted = ascii_lower(topic);
  const auto plain = std::string_view(wanted).substr(wanted.starts_with('/') ? 1 : 0);
  const auto out = std::min(edits_to_match(expression, wanted),
                            edits_to_match(expression, "rt/" + std::string(plain)));
  return out <= max_edits(longest_part(expression)) ? std::optional(out) : std::nullopt;
}

// Finds the allowed name that is nearest to a name that is not allowed.
class NearestName {
 public:
  explicit NearestName(std::string_view topic) : topic_(topic) {}

  void look_at(const Criteria& criteria) {
    for (const auto& text : criteria.topics) {
      if (seen_ == kMaxNames) return;
      ++seen_;
      if (text.text.size() > kMaxNameOctets) continue;
      const auto far = distance_of(text.text);
      if (!far || (name_ && *far >= distance_)) continue;
      distance_ = *far;
      name_ = text.text;
    }
  }
  const std::optional<std::string>& name() const { return name_; }
  bool is_expression() const { return name_ && name_->find_first_of("*?") != name_->npos; }

 private:
  std::optional<std::size_t> distance_of(std::string_view allowed) const {
    if (allowed.find_first_of("[\\") != allowed.npos) return std::nullopt;
    const bool is_name = allowed.find_first_of("*?") == allowed.npos;
    return is_name ? distance(allowed, topic_) : distance_to_expression(allowed, topic_);
  }

  std::string_view topic_;
  std::size_t seen_ = 0;
  std::size_t distance_ = 0;
  std::optional<std::string> name_;
};

// The other nodes of ROS 2 to whose parameter services the grant allows to reply; at most three.
std::vector<std::string> other_nodes(const CompiledGrant& grant, std::string_view node) {
  constexpr std::size_t kMaxNodes = 3;
  std::vector<std::string> out;
  std::size_t seen = 0;
  for (const auto* criteria : grant.allowed(Action::publish))
    for (const auto& text : criteria->topics) {
      if (++seen > kMaxNames || out.size() == kMaxNodes) return out;
      const std::string other(node_of_parameter_service(text.text));
      if (other == node) return {};
      if (!other.empty() && std::ranges::find(out, other) == out.end()) out.push_back(other);
    }
  return out;
}

// Every node replies to its parameter services, so such a topic says which node asks.
RefusalAdvice about_node(const CompiledGrant& grant, std::string_view topic) {
  const auto node = node_of_parameter_service(topic);
  if (node.empty()) return {};
  const auto others = other_nodes(grant, node);
  if (others.empty()) return {};
  const auto shown = name_list(others);
  return {
      .because = fmt::format("the permissions are for the ROS 2 node {}", shown),
      .hint = fmt::format("the node {} asks, and the permissions are for {}: start it with its "
                          "own enclave (--ros-args --enclave NAME), or add its <profile> to the "
                          "policy and run ddssec keystore permission with --node-defaults",
                          cut_name(node), shown)};
}

}  // namespace

std::string partitions_of(const Criteria& criteria) {
  if (!criteria.partitions) return "only without a partition (or in \"\")";
  if (std::ranges::find(*criteria.partitions, "*", &Text::text) != criteria.partitions->end())
    return {};
  std::vector<std::string_view> texts;
  for (const auto& text : *criteria.partitions) texts.push_back(text.text);
  return "only in " + name_list(texts);
}

RefusalAdvice advice_on_endpoint(const CompiledGrant& grant, Action action, const Request& request,
                                 const Decision& decision) {
  const bool is_denied = decision.rule != nullptr && !decision.rule->allow;
  if (decision.allowed || is_denied || grant.judge(action, request).allowed) return {};
  const auto somewhere = grant.judge_topic(action, request.topic);
  if (!somewhere.allowed || somewhere.criteria == nullptr) return {};
  const Request untagged{.topic = request.topic, .partitions = request.partitions};
  const bool is_for_tags = !request.data_tags.empty() && grant.judge(action, untagged).allowed;
  return is_for_tags ? about_data_tags(*somewhere.criteria)
                     : about_partitions(*somewhere.criteria, request);
}

RefusalAdvice advice_on_name(const CompiledGrant& grant, Action action, std::string_view topic) {
  if (topic.size() > kMaxNameOctets) return {};
  if (auto advice = about_node(grant, topic); !advice.hint.empty()) return advice;
  NearestName nearest(topic);
  for (const auto* criteria : grant.allowed(action)) nearest.look_at(*criteria);
  if (!nearest.name()) return {};
  const auto allowed = cut_name(*nearest.name());
  const auto question =
      nearest.is_expression()
          ? fmt::format(
                "is a name that {0} matches meant? Correct the name in the program, correct "
                "{0} in the grant",
                allowed)
          : fmt::format("is {} meant? Correct the name in the program", allowed);
  return {
      .because = fmt::format("{} is allowed", allowed),
      .hint = fmt::format("{}, or add {} to an allow_rule of the grant{} sign the permissions "
                          "again",
                          question, cut_name(topic), nearest.is_expression() ? ", and" : " and")};
}

std::string hint_for_ros_topic(std::string_view topic) {
  if (!topic.starts_with("rt/") && !topic.starts_with("rq/") && !topic.starts_with("rr/"))
    return {};
  return "in a keystore of ROS 2, allow the topic in the enclave's policy, then: ddssec keystore "
         "permission KEYSTORE ENCLAVE --policy FILE --node-defaults; elsewhere, add it to an "
         "allow_rule of the grant, before any deny_rule that matches it, and sign the permissions "
         "again";
}

RefusalAdvice advice_on(const CompiledGrant& grant, Action action, const Request& request,
                        const Decision& decision) {
  auto out = advice_on_endpoint(grant, action, request, decision);
  if (!out.hint.empty() || decision.allowed || decision.rule != nullptr) return out;
  return advice_on_name(grant, action, request.topic);
}

}  // namespace ddssec::governance
