#include "governance/ros_policy.hpp"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "base/stable_sort.hpp"
#include "governance/write.hpp"

namespace ddssec::governance {
namespace {

constexpr std::string_view kDiscoveryTopic = "ros_discovery_info";
constexpr std::string_view kActionServices[] = {"cancel_goal", "get_result", "send_goal"};

// DDS names that one policy element gives, in its order. Such groups are ordered by their first
// names only.
using Group = std::vector<std::string>;

// The topics that are published and subscribed with one qualifier.
struct Uses {
  std::vector<Group> publish = {}, subscribe = {};
  bool empty() const { return publish.empty() && subscribe.empty(); }
};

// The topics of both qualifiers.
struct Rights {
  Uses allow = {}, deny = {};
};

Group requests(const std::string& name) { return {"rq" + name + "Request"}; }
Group replies(const std::string& name) { return {"rr" + name + "Reply"}; }

Group action_requests(const std::string& name) {
  Group out;
  for (const auto service : kActionServices)
    out.push_back(fmt::format("rq{}/_action/{}Request", name, service));
  return out;
}

// Includes the topics on which the server reports progress.
Group action_replies(const std::string& name) {
  Group out;
  for (const auto service : kActionServices)
    out.push_back(fmt::format("rr{}/_action/{}Reply", name, service));
  out.push_back(fmt::format("rt{}/_action/feedback", name));
  out.push_back(fmt::format("rt{}/_action/status", name));
  return out;
}

// The topics that one kind of use publishes and subscribes (ROS 2 design: ROS and DDS names).
struct Way {
  Group (*publish)(const std::string&);
  Group (*subscribe)(const std::string&);
};

Group topic(const std::string& name) { return {"rt" + name}; }
Group nothing(const std::string&) { return {}; }

Way way(RosKind kind, bool first) {
  switch (kind) {
    case RosKind::topics:
      return first ? Way{topic, nothing} : Way{nothing, topic};
    case RosKind::services:
      return first ? Way{replies, requests} : Way{requests, replies};
    case RosKind::actions:
      break;
  }
  return first ? Way{action_requests, action_replies} : Way{action_replies, action_requests};
}

void append(Group& to, Group from) {
  to.insert(to.end(), std::make_move_iterator(from.begin()), std::make_move_iterator(from.end()));
}

void add(Rights& rights, const RosProfile& profile, const RosElement& element, bool first) {
  const auto qualifier = first ? element.first : element.second;
  if (qualifier == RosQualifier::unsaid) return;
  auto& uses = qualifier == RosQualifier::allow ? rights.allow : rights.deny;
  const auto [publish, subscribe] = way(element.kind, first);
  Group published, subscribed;
  for (const auto& name : element.names) {
    const auto expanded = expanded_ros_name(profile, name);
    append(published, publish(expanded));
    append(subscribed, subscribe(expanded));
  }
  if (!published.empty()) uses.publish.push_back(std::move(published));
  if (!subscribed.empty()) uses.subscribe.push_back(std::move(subscribed));
}

Rights rights_of(const std::vector<RosProfile>& profiles) {
  Rights out;
  for (const auto& profile : profiles)
    for (const auto& element : profile.elements)
      for (const bool first : {true, false}) add(out, profile, element, first);
  return out;
}

std::vector<Text> each_once(const std::vector<Group>& groups) {
  std::vector<Text> out;
  std::set<std::string_view> seen;
  for (const auto& group : groups)
    for (const auto& name : group)
      if (seen.insert(name).second) out.push_back({name, 0});
  return out;
}

std::vector<Text> in_order(std::vector<Group> groups) {
  stable_sort_by(groups, [](const Group& group) { return group.front(); });
  return each_once(groups);
}

std::vector<Text> sorted(const std::vector<Group>& groups) {
  auto out = each_once(groups);
  std::ranges::sort(out, {}, &Text::text);
  return out;
}

using Order = std::vector<Text> (*)(std::vector<Group>);

enum class RuleKind : std::uint8_t { deny, allow };

void add_rule(Grant& grant, RuleKind kind, DomainId domain, std::vector<Text> publish,
              std::vector<Text> subscribe) {
  GrantRule rule{.allow = kind == RuleKind::allow, .domains = {.ranges = {{domain, domain}}}};
  if (!publish.empty()) rule.publish.push_back({.topics = std::move(publish)});
  if (!subscribe.empty()) rule.subscribe.push_back({.topics = std::move(subscribe)});
  grant.rules.push_back(std::move(rule));
}

// A denial in any profile overrides the rights in others. The first rule for the domain decides
// which participants join it (DDS-Security 1.2 table 70), so an allow rule without topics comes
// before denials.
Grant grant_of(const RosEnclave& enclave, const Rights& rights,
               const RosPermissionsOptions& options, Order order) {
  Grant grant{
      .name = enclave.path, .subject_name = "CN=" + enclave.path, .validity = options.validity};
  if (!rights.deny.empty()) add_rule(grant, RuleKind::allow, options.domain, {}, {});
  for (const auto& [kind, uses] :
       {std::pair(RuleKind::deny, &rights.deny), std::pair(RuleKind::allow, &rights.allow)})
    if (!uses->empty())
      add_rule(grant, kind, options.domain, order(uses->publish), order(uses->subscribe));
  const std::vector<Text> discovery = {{std::string(kDiscoveryTopic), 0}};
  if (options.discovery_topic)
    add_rule(grant, RuleKind::allow, options.domain, discovery, discovery);
  return grant;
}

std::string replaced(std::string_view text, std::string_view from, std::string_view to) {
  std::string out;
  for (auto at = text.find(from); at != text.npos; at = text.find(from)) {
    out.append(text.substr(0, at)).append(to);
    text.remove_prefix(at + from.size());
  }
  return out.append(text);
}

}  // namespace

std::string expanded_ros_name(const RosProfile& profile, std::string_view name) {
  if (name.starts_with('/')) return std::string(name);
  const auto slash = profile.ns.ends_with('/') ? "" : "/";
  if (name.starts_with('~'))
    return fmt::format("{}{}{}{}", profile.ns, slash, profile.node, name.substr(1));
  return fmt::format("{}{}{}", profile.ns, slash, name);
}

Permissions permissions_of(const RosPolicy& policy, const RosPermissionsOptions& options) {
  Permissions out;
  for (const auto& enclave : policy.enclaves) {
    std::vector<RosProfile> all;
    for (const auto& other : policy.enclaves)
      if (other.path == enclave.path)
        for (const auto& list : other.profiles) all.insert(all.end(), list.begin(), list.end());
    if (std::ranges::find(out.grants, enclave.path, &Grant::name) == out.grants.end())
      out.grants.push_back(grant_of(enclave, rights_of(all), options,
                                    [](std::vector<Group> groups) { return sorted(groups); }));
  }
  return out;
}

std::string sros2_permissions(const RosPolicy& policy, const RosPermissionsOptions& options) {
  Permissions document;
  for (const auto& enclave : policy.enclaves)
    for (const auto& list : enclave.profiles)
      document.grants.push_back(grant_of(enclave, rights_of(list), options, in_order));
  auto xml = to_xml(document);
  constexpr std::string_view kRoot =
      "<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:noNamespaceSchemaLocation="
      "\"http://www.omg.org/spec/DDS-SECURITY/20170901/omg_shared_ca_permissions.xsd\">";
  xml.erase(0, xml.find("<dds>"));
  xml.replace(0, std::string_view("<dds>").size(), kRoot);
  for (const std::string_view end : {"</not_before>", "</not_after>"})
    xml = replaced(std::move(xml), fmt::format("Z{}", end), end);
  return replaced(std::move(xml), "&quot;", "\"");
}

}  // namespace ddssec::governance
