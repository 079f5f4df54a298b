#include "governance/ros_node.hpp"

#include <algorithm>
#include <array>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "governance/decision.hpp"
#include "governance/lint_findings.hpp"

namespace ddssec::governance {
namespace {

constexpr std::array<std::string_view, 6> kParameterServices = {
    "describe_parameters", "get_parameter_types", "get_parameters",
    "list_parameters",     "set_parameters",      "set_parameters_atomically"};
constexpr std::string_view kReplies = "rr", kReply = "Reply";
constexpr std::size_t kMaxNodes = 64, kMaxNamedNodes = 3, kMaxNamedGrants = 3;

std::string request_topic(std::string_view node, std::string_view service) {
  return fmt::format("rq{}/{}Request", node, service);
}
std::string reply_topic(std::string_view node, std::string_view service) {
  return fmt::format("{}{}/{}{}", kReplies, node, service, kReply);
}

template <class Each>
void each_topic(const Grant& grant, Each&& each) {
  for (const auto& rule : grant.rules)
    for (const auto* list : {&rule.publish, &rule.subscribe})
      for (const auto& criteria : *list)
        for (const auto& topic : criteria.topics) each(rule, topic.text, list == &rule.publish);
}

// Names of nodes whose services a grant may be about.
struct Nodes {
  std::set<std::string> named;    // one of the services is named for the node
  std::set<std::string> guessed;  // an expression may mean the node

  void add(std::string_view expression) {
    if (named.size() + guessed.size() >= kMaxNodes) return;
    if (!expression.starts_with("rr/") || !add_name(expression)) add_expression(expression);
  }

 private:
  bool add_name(std::string_view expression) {
    for (const auto service : kParameterServices) {
      const auto end = reply_topic("", service).substr(kReplies.size());
      if (!expression.ends_with(end)) continue;
      named.emplace(
          expression.substr(kReplies.size(), expression.size() - kReplies.size() - end.size()));
      return true;
    }
    return false;
  }
  void add_expression(std::string_view expression) {
    const auto wild = expression.find_first_of("*?[");
    if (wild == expression.npos) return;
    auto begin = expression.substr(0, wild);
    if (std::string_view("rr/").starts_with(begin)) {
      guessed.emplace("/node");
      return;
    }
    if (!begin.starts_with("rr/")) return;
    begin.remove_prefix(kReplies.size());
    guessed.emplace(std::string(begin.substr(0, begin.rfind('/'))) + "/node");
    guessed.emplace(begin.substr(0, begin.find_last_not_of('/') + 1));
  }
};

// The topics of the rights that nodes need, sorted.
std::vector<std::string> asked_topics(const Nodes& nodes) {
  std::vector<std::string> out = {"rt/parameter_events", "rt/rosout"};
  for (const auto* names : {&nodes.named, &nodes.guessed})
    for (const auto& node : *names)
      for (const auto service : kParameterServices) {
        out.push_back(request_topic(node, service));
        out.push_back(reply_topic(node, service));
      }
  std::ranges::sort(out);
  return out;
}

// True if the expression may match one of the sorted `topics`.
bool may_match(std::string_view expression, const std::vector<std::string>& topics) {
  const auto wild = expression.find_first_of("*?[");
  const auto begin = expression.substr(0, wild);
  const auto at = std::lower_bound(topics.begin(), topics.end(), begin);
  if (at == topics.end()) return false;
  return wild == expression.npos ? *at == expression : at->starts_with(begin);
}

std::vector<Criteria> only_about(const std::vector<std::string>& topics,
                                 const std::vector<Criteria>& list) {
  std::vector<Criteria> out;
  for (const auto& criteria : list) {
    std::vector<Text> kept;
    for (const auto& topic : criteria.topics)
      if (may_match(topic.text, topics)) kept.push_back(topic);
    if (!kept.empty())
      out.push_back({std::move(kept), criteria.partitions, criteria.data_tags, criteria.line});
  }
  return out;
}

// The grant without the expressions that match none of `topics`. It decides the same for these
// topics. Compiling tens of thousands of other expressions would take longer than the rest of lint.
Grant only_about(const std::vector<std::string>& topics, const Grant& grant) {
  Grant out{.default_allow = grant.default_allow};
  for (const auto& rule : grant.rules)
    out.rules.push_back({.allow = rule.allow,
                         .domains = rule.domains,
                         .publish = only_about(topics, rule.publish),
                         .subscribe = only_about(topics, rule.subscribe)});
  return out;
}

std::vector<DomainId> domains_of(const Grant& grant) {
  std::vector<DomainId> out;
  for (const auto& rule : grant.rules)
    if (rule.allow && !rule.domains.ranges.empty() &&
        std::ranges::find(out, rule.domains.ranges.front().first) == out.end())
      out.push_back(rule.domains.ranges.front().first);
  constexpr std::size_t kMaxDomains = 8;
  if (out.size() > kMaxDomains) out.resize(kMaxDomains);
  return out;
}

// The rights of a node in one domain, by the grant.
class NodeRights {
 public:
  // `grant` must outlive this object.
  NodeRights(const Grant& grant, DomainId domain) : grant_(nullptr, grant, domain) {}

  std::vector<std::string> missing(const Nodes& nodes) const {
    std::vector<std::string> out;
    if (!may(Action::publish, "rt/rosout")) out.emplace_back("publish rosout");
    if (!may(Action::publish, "rt/parameter_events")) out.emplace_back("publish parameter_events");
    if (!may(Action::subscribe, "rt/parameter_events"))
      out.emplace_back("subscribe to parameter_events");
    add_services(nodes, out);
    return out;
  }

 private:
  bool may(Action action, const std::string& topic) const {
    return grant_.judge(action, {.topic = topic}).allowed;
  }
  bool may_reply(std::string_view node, std::string_view service) const {
    return may(Action::publish, reply_topic(node, service)) &&
           may(Action::subscribe, request_topic(node, service));
  }
  bool may_reply_to_all(std::string_view node) const {
    return std::ranges::all_of(kParameterServices,
                               [&](auto service) { return may_reply(node, service); });
  }
  void add_services(const Nodes& nodes, std::vector<std::string>& out) const {
    if (nodes.named.empty()) {
      if (std::ranges::any_of(nodes.guessed, [&](const auto& n) { return may_reply_to_all(n); }))
        return;
      for (const auto service : kParameterServices)
        out.push_back(fmt::format("reply to ~/{}", service));
      return;
    }
    std::size_t incomplete = 0;
    for (const auto& node : nodes.named) {
      if (may_reply_to_all(node) || ++incomplete > kMaxNamedNodes) continue;
      for (const auto service : kParameterServices)
        if (!may_reply(node, service)) out.push_back(fmt::format("reply to {}/{}", node, service));
    }
  }

  CompiledGrant grant_;
};

Nodes nodes_of(const Grant& grant) {
  Nodes out;
  each_topic(grant, [&](const GrantRule& rule, const std::string& text, bool publish) {
    if (rule.allow && publish) out.add(text);
  });
  if (grant.default_allow) out.guessed.emplace("/node");
  return out;
}

std::vector<std::string> missing_in(const Grant& grant) {
  const auto nodes = nodes_of(grant);
  const auto needed = only_about(asked_topics(nodes), grant);
  std::vector<std::string> least;
  bool is_first = true;
  for (const auto domain : domains_of(grant)) {
    auto missing = NodeRights(needed, domain).missing(nodes);
    if (is_first || missing.size() < least.size()) least = std::move(missing);
    is_first = false;
  }
  return least;
}

}  // namespace

RosPolicy with_node_defaults(RosPolicy policy) {
  using enum RosQualifier;
  RosElement log{RosKind::topics, allow, unsaid, {"/rosout"}};
  RosElement events{RosKind::topics, allow, allow, {"/parameter_events"}};
  RosElement services{RosKind::services, allow, unsaid, {}};
  for (const auto service : kParameterServices)
    services.names.push_back(fmt::format("~/{}", service));
  for (auto& enclave : policy.enclaves)
    for (auto& list : enclave.profiles)
      for (auto& profile : list)
        profile.elements.insert(profile.elements.end(), {log, events, services});
  return policy;
}

bool speaks_of_ros(const Grant& grant) {
  bool out = false;
  each_topic(grant, [&](const GrantRule&, std::string_view text, bool) {
    out = out || text == "ros_discovery_info" || text.starts_with("rt/") ||
          text.starts_with("rq/") || text.starts_with("rr/");
  });
  return out;
}

std::string_view node_of_parameter_service(std::string_view topic) {
  constexpr auto kPrefixOctets = kReplies.size();  // also of "rq"
  for (const auto service : kParameterServices)
    for (const auto& name : {reply_topic("", service), request_topic("", service)}) {
      const auto prefix = std::string_view(name).substr(0, kPrefixOctets);
      const auto end = std::string_view(name).substr(kPrefixOctets);
      const bool is_of_it = topic.starts_with(prefix) && topic.ends_with(end) &&
                            topic.size() > name.size() + 1 && topic[kPrefixOctets] == '/';
      if (is_of_it) return topic.substr(kPrefixOctets, topic.size() - name.size());
    }
  return {};
}

std::vector<std::string> missing_node_rights(const Grant& grant, DomainId domain) {
  const auto nodes = nodes_of(grant);
  const auto needed = only_about(asked_topics(nodes), grant);
  return NodeRights(needed, domain).missing(nodes);
}

std::optional<Finding> missing_node_defaults(const Permissions& permissions) {
  std::string said;
  std::size_t grants = 0;
  int line = 0;
  std::string path;
  for (const auto& grant : permissions.grants) {
    if (!speaks_of_ros(grant)) continue;
    const auto missing = missing_in(grant);
    if (missing.empty() || ++grants > kMaxNamedGrants) continue;
    if (said.empty()) {
      line = grant.line;
      path = fmt::format("/dds/permissions/grant[{}]", &grant - permissions.grants.data() + 1);
    }
    said += fmt::format("{}grant {} does not allow it to {}", said.empty() ? "" : "; ",
                        in_quotes(grant.name), fmt::join(missing, ", "));
  }
  if (grants == 0) return std::nullopt;
  if (grants > kMaxNamedGrants)
    said += fmt::format("; {} more grants lack such rights", grants - kMaxNamedGrants);
  return Finding{.rule = Rule::PERM040,
                 .message = fmt::format("an rclcpp node would not start: {}", said),
                 .line = line,
                 .path = std::move(path)};
}

}  // namespace ddssec::governance
