// Findings about rights of ROS 2 nodes: halves of services, the discovery and log topics, names.
#include "tests/unit/governance/permissions_lint.hpp"

namespace ddssec::governance {
namespace {

const char* const kDiscovery = "ros_discovery_info";

// Returns the findings except PERM040, which ros_node_test.cpp tests.
std::vector<Finding> lint_of_topics(const Rights& rights) {
  auto found = lint_but_joining(with(rights));
  std::erase_if(found, [](const Finding& f) { return f.rule == ddssec::Rule::PERM040; });
  return found;
}
Finding only_of_topics(const Rights& rights) {
  const auto found = lint_of_topics(rights);
  EXPECT_EQ(found.size(), 1u);
  return found.empty() ? Finding{ddssec::Rule::end_, ""} : found.front();
}

TEST(LintRos, HalvesOfServices_AreFound) {
  const auto server = rights({"rr/addReply", kDiscovery}, {"rq/addRequest", kDiscovery});
  EXPECT_TRUE(lint_of_topics(server).empty());
  const auto half =
      only_of_topics(rights({"rr/addReply", kDiscovery}, {"rq/subRequest*", kDiscovery}));
  EXPECT_EQ(half.rule, ddssec::Rule::PERM030);
  EXPECT_EQ(half.message,
            "to publish \"rr/addReply\" is allowed, to subscribe \"rq/addRequest\" is not");
  // The second expression repeats the first.
  only_of_topics(rights({"rq/*Request", "rq/aRequest", kDiscovery}, {"rr/*", kDiscovery}));
}

TEST(LintRos, MissingDiscoveryAndLogTopicsOfRos_AreFound) {
  const auto found = lint_of_topics(rights({"rt/chatter"}));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].rule, ddssec::Rule::PERM032);
  EXPECT_EQ(found[1].message, "to subscribe ros_discovery_info is not allowed");
  EXPECT_EQ(only_of_topics(rights({"rt/robot1/rosout", kDiscovery}, {kDiscovery})).rule,
            ddssec::Rule::PERM033);
  EXPECT_TRUE(
      lint_of_topics(rights({"rt/robot1/rosout", "rt/*", kDiscovery}, {kDiscovery})).empty());
}

TEST(LintRos, NamesOfRos_AreFound) {
  EXPECT_EQ(only(with(rights({"/chatter"}))).rule, ddssec::Rule::PERM034);
}

}  // namespace
}  // namespace ddssec::governance
