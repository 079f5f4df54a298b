#include "governance/ros_node.hpp"

#include <algorithm>

#include "governance/decision.hpp"
#include "governance/lint.hpp"
#include "governance/write.hpp"
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

using enum RosQualifier;

RosElement topics(RosQualifier publish, RosQualifier subscribe, std::vector<std::string> names) {
  return {RosKind::topics, publish, subscribe, std::move(names)};
}

// Returns a policy with one enclave, /e, that has one node.
RosPolicy policy(std::vector<RosElement> elements, std::string ns = "/",
                 std::string node = "talker") {
  return {{{.path = "/e", .profiles = {{{std::move(ns), std::move(node), std::move(elements)}}}}}};
}
const RosElement kChatter = topics(allow, unsaid, {"chatter"});

Permissions granted(const RosPolicy& policy) { return permissions_of(policy, {.domain = 0}); }

bool may(const Permissions& document, Action action, std::string_view topic) {
  const auto shared = std::make_shared<const Permissions>(document);
  return CompiledGrant(shared, shared->grants.front(), 0).judge(action, {.topic = topic}).allowed;
}

Permissions allowing(std::vector<std::string> publish, std::vector<std::string> subscribe) {
  GrantRule rule{.allow = true, .domains = {.ranges = {{0, 0}}}};
  const auto texts = [](const std::vector<std::string>& names) {
    std::vector<Text> out;
    for (const auto& name : names) out.push_back({name, 1});
    return out;
  };
  rule.publish.push_back({.topics = texts(publish)});
  rule.subscribe.push_back({.topics = texts(subscribe)});
  return {.grants = {{.name = "/e", .subject_name = "CN=/e", .rules = {rule}, .line = 4}}};
}

TEST(ParameterService, ItsTopics_NameTheNode) {
  EXPECT_EQ(node_of_parameter_service("rr/talker/get_parametersReply"), "/talker");
  EXPECT_EQ(node_of_parameter_service("rq/robot/arm/set_parametersRequest"), "/robot/arm");
  EXPECT_EQ(node_of_parameter_service("rr/a/set_parameters_atomicallyReply"), "/a");
  for (const auto* other :
       {"", "rr", "rr/get_parametersReply", "rr//get_parametersReply", "rr/a/addReply",
        "rr/a/get_parametersRequest", "rt/a/get_parametersReply", "rrx/a/get_parametersReply"})
    EXPECT_EQ(node_of_parameter_service(other), "") << other;
}

TEST(NodeDefaults, NodesPolicy_AllowsWhatAnRclcppNodeCreates) {
  const auto document = granted(with_node_defaults(policy({kChatter}, "/robot", "camera")));
  EXPECT_TRUE(may(document, Action::publish, "rt/robot/chatter"));
  EXPECT_TRUE(may(document, Action::publish, "rt/rosout"));
  EXPECT_FALSE(may(document, Action::subscribe, "rt/rosout"));
  EXPECT_TRUE(may(document, Action::publish, "rt/parameter_events"));
  EXPECT_TRUE(may(document, Action::subscribe, "rt/parameter_events"));
  for (const std::string service :
       {"describe_parameters", "get_parameter_types", "get_parameters", "list_parameters",
        "set_parameters", "set_parameters_atomically"}) {
    EXPECT_TRUE(may(document, Action::publish, "rr/robot/camera/" + service + "Reply")) << service;
    EXPECT_TRUE(may(document, Action::subscribe, "rq/robot/camera/" + service + "Request"));
    EXPECT_FALSE(may(document, Action::publish, "rq/robot/camera/" + service + "Request"));
  }
  EXPECT_EQ(missing_node_defaults(document), std::nullopt);
}

TEST(NodeDefaults, AddedTwice_AreThereOnce) {
  const auto once = with_node_defaults(policy({kChatter}));
  EXPECT_EQ(to_xml(granted(with_node_defaults(once))), to_xml(granted(once)));
}

TEST(NodeDefaults, EachNodeOfTheEnclave_HasThem) {
  auto two = policy({kChatter});
  two.enclaves[0].profiles[0].push_back({"/", "other", {kChatter}});
  const auto document = granted(with_node_defaults(two));
  EXPECT_TRUE(may(document, Action::publish, "rr/talker/set_parametersReply"));
  EXPECT_TRUE(may(document, Action::publish, "rr/other/set_parametersReply"));
}

TEST(NodeDefaults, WhatThePolicyDenies_StaysDenied) {
  const RosElement no_changes{RosKind::services, deny, unsaid, {"~/set_parameters"}};
  const auto document = granted(
      with_node_defaults(policy({kChatter, no_changes, topics(deny, unsaid, {"/rosout"})})));
  EXPECT_FALSE(may(document, Action::publish, "rr/talker/set_parametersReply"));
  EXPECT_FALSE(may(document, Action::publish, "rt/rosout"));
  EXPECT_TRUE(may(document, Action::publish, "rr/talker/get_parametersReply"));
  const auto found = missing_node_defaults(document);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->message.ends_with(
      "does not allow it to publish rosout, reply to /talker/set_parameters"))
      << found->message;
}

TEST(MissingNodeDefaults, AllMissingOnes_AreNamedInOneFinding) {
  const auto found = missing_node_defaults(granted(policy({kChatter})));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->rule, ddssec::Rule::PERM040);
  EXPECT_EQ(found->message,
            "an rclcpp node would not start: grant \"/e\" does not allow it to publish rosout, "
            "publish parameter_events, subscribe to parameter_events, reply to "
            "~/describe_parameters, reply to ~/get_parameter_types, reply to ~/get_parameters, "
            "reply to ~/list_parameters, reply to ~/set_parameters, reply to "
            "~/set_parameters_atomically");
  EXPECT_NE(std::string(info(found->rule).hint).find("--node-defaults"), std::string::npos);
}

TEST(MissingNodeDefaults, EachOfThem_IsMissed) {
  const auto whole = granted(with_node_defaults(policy({kChatter})));
  const auto& rule = whole.grants[0].rules[0];
  std::size_t needed = 0;
  for (const bool publish : {true, false}) {
    const auto& names = (publish ? rule.publish : rule.subscribe).at(0).topics;
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (names[i].text == "rt/chatter") continue;
      auto less = whole;
      auto& list = publish ? less.grants[0].rules[0].publish : less.grants[0].rules[0].subscribe;
      list[0].topics.erase(list[0].topics.begin() + static_cast<std::ptrdiff_t>(i));
      const auto found = missing_node_defaults(less);
      EXPECT_TRUE(found) << names[i].text;
      ++needed;
    }
  }
  EXPECT_EQ(needed, 15u);  // rosout, parameter_events twice, two halves of six services
}

TEST(MissingNodeDefaults, Expressions_MayGrantThem) {
  const auto lacks = [](std::vector<std::string> publish, std::vector<std::string> subscribe) {
    return missing_node_defaults(allowing(std::move(publish), std::move(subscribe))).has_value();
  };
  EXPECT_FALSE(lacks({"rt/*", "rr/*"}, {"rt/*", "rq/*"}));
  EXPECT_FALSE(lacks({"rt/*", "rr/talker/*"}, {"rt/*", "rq/talker/*"}));
  EXPECT_FALSE(lacks({"rt/*", "rr/talker/*Reply"}, {"rt/*", "rq/talker/*Request"}));
  EXPECT_FALSE(lacks({"rt/chatter", "*"}, {"*"}));
  EXPECT_FALSE(lacks({"rt/ros?ut", "rt/parameter_event[s]", "[r]r/*"}, {"[r]t/*", "rq/*"}));
  EXPECT_TRUE(lacks({"rt/*", "rr/talker/*"}, {"rt/*", "rq/listener/*"}));
  EXPECT_TRUE(lacks({"rt/*", "rr/a*"}, {"rt/*"}));
}

TEST(MissingNodeDefaults, WhatDoesNotLookLikeRos_IsLeftAlone) {
  EXPECT_FALSE(missing_node_defaults(allowing({"Square"}, {"Circle"})));
  EXPECT_FALSE(missing_node_defaults(allowing({"*"}, {"*"})));
  EXPECT_TRUE(missing_node_defaults(allowing({"ros_discovery_info"}, {})));
  EXPECT_TRUE(missing_node_defaults(allowing({"rr/addReply"}, {"rq/addRequest"})));
}

TEST(MissingNodeDefaults, SeveralGrants_AreOneFinding) {
  auto document = granted(policy({kChatter}));
  for (int i = 0; i < 4; ++i) document.grants.push_back(document.grants.front());
  const auto found = missing_node_defaults(document);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->message.ends_with("; 2 more grants lack such rights")) << found->message;
}

TEST(MissingNodeDefaults, ADomainOfTheGrant_IsEnough) {
  auto document = granted(with_node_defaults(policy({kChatter})));
  auto other = granted(policy({kChatter})).grants[0].rules[0];
  other.domains.ranges = {{5, 5}};
  document.grants[0].rules.push_back(other);
  EXPECT_FALSE(missing_node_defaults(document));
}

}  // namespace
}  // namespace ddssec::governance
