#include "governance/ros_policy.hpp"

#include "governance/write.hpp"
#include "pki/certificate_source.hpp"
#include "tests/support/test_data.hpp"
#include "tests/unit/governance/ros_policies.hpp"
#include "tests/unit/governance/schema.hpp"

namespace ddssec::governance {
namespace {

using namespace std::chrono;

// The dates of sros2's template, for policies without dates of their own.
constexpr Validity kTemplate{sys_days(2020y / May / 1), sys_days(2030y / May / 1)};

std::string data_text(const std::string& name) {
  return std::string(as_text(data_file("sros2/" + name)));
}

Result<Bytes> from_data(const std::filesystem::path& file) {
  return pki::load_uri("file://" + file.string(), "", 1 << 20);
}

Result<RosPolicy> policy_of(const std::string& name) {
  return read_ros_policy(test::data_path("sros2/" + name), from_data);
}

struct Golden {
  const char *policy, *expected;
  bool discovery;
};
class Sros2Golden : public ::testing::TestWithParam<Golden> {};

TEST_P(Sros2Golden, EachPolicy_GivesTheSameOctets) {
  const auto& [name, expected, discovery] = GetParam();
  const auto policy = policy_of(name);
  ASSERT_TRUE(policy) << policy.error().to_sentence();
  const auto xml =
      sros2_permissions(*policy, {.validity = kTemplate, .discovery_topic = discovery});
  EXPECT_EQ(xml, data_text(expected));
  EXPECT_TRUE(is_valid(xml, "permissions.xsd"));
}

INSTANTIATE_TEST_SUITE_P(
    All, Sros2Golden,
    ::testing::Values(Golden{"upstream/policies/talker_listener.policy.xml",
                             "upstream/permissions/talker_listener/permissions.xml", false},
                      Golden{"upstream/policies/add_two_ints.policy.xml",
                             "upstream/permissions/add_two_ints/permissions.xml", false},
                      Golden{"upstream/policies/talker_listener.policy.xml",
                             "generated/expected/talker_listener.with_discovery.permissions.xml",
                             true},
                      Golden{"upstream/policies/add_two_ints.policy.xml",
                             "generated/expected/add_two_ints.with_discovery.permissions.xml",
                             true},
                      Golden{"generated/policies/ordering.policy.xml",
                             "generated/expected/ordering.permissions.xml", false},
                      Golden{"generated/policies/ordering.policy.xml",
                             "generated/expected/ordering.with_discovery.permissions.xml", true}));

TEST(RosNames, EachForm_IsExpandedAsTheNodeDoes) {
  const RosProfile root{"/", "m"}, below{"/a/b", "m"};
  EXPECT_EQ(expanded_ros_name(below, "/x"), "/x");
  EXPECT_EQ(expanded_ros_name(below, "~"), "/a/b/m");
  EXPECT_EQ(expanded_ros_name(below, "~/x"), "/a/b/m/x");
  EXPECT_EQ(expanded_ros_name(root, "~/x"), "/m/x");
  EXPECT_EQ(expanded_ros_name(below, "x"), "/a/b/x");
  EXPECT_EQ(expanded_ros_name(root, "x"), "/x");
  EXPECT_EQ(expanded_ros_name(below, " x "), "/a/b/ x ");
}

std::vector<std::string> names(const std::vector<Criteria>& list) {
  std::vector<std::string> out;
  for (const auto& criteria : list)
    for (const auto& topic : criteria.topics) out.push_back(topic.text);
  return out;
}

TEST(RosPolicies, SeveralProfiles_AreMergedAndDenialsWin) {
  auto text = profile("<topics publish=\"ALLOW\"><topic>b</topic><topic>/a</topic></topics>");
  text = pki::replaced(text, "</profiles>",
                       "</profiles><profiles><profile ns=\"/\" node=\"o\"><topics publish=\"DENY\" "
                       "subscribe=\"ALLOW\"><topic>/a</topic></topics></profile></profiles>");
  const auto policy = policy_from({{"policy.xml", text}});
  ASSERT_TRUE(policy) << policy.error().to_sentence();
  const auto document = permissions_of(*policy, {.domain = 7, .validity = kTemplate});
  ASSERT_EQ(document.grants.size(), 1u);
  const auto& grant = document.grants[0];
  EXPECT_EQ(grant.subject_name, "CN=/e");
  ASSERT_EQ(grant.rules.size(), 4u);
  EXPECT_TRUE(grant.rules[0].allow) << "the first rule decides about joining";
  EXPECT_TRUE(grant.rules[0].publish.empty());
  EXPECT_TRUE(grant.rules[0].subscribe.empty());
  EXPECT_FALSE(grant.rules[1].allow);
  EXPECT_EQ(names(grant.rules[1].publish), std::vector<std::string>{"rt/a"});
  EXPECT_EQ(names(grant.rules[2].publish), (std::vector<std::string>{"rt/a", "rt/n/b"}));
  EXPECT_EQ(names(grant.rules[2].subscribe), std::vector<std::string>{"rt/a"});
  EXPECT_EQ(names(grant.rules[3].publish), std::vector<std::string>{"ros_discovery_info"});
  EXPECT_EQ(grant.rules[3].domains.ranges[0], (DomainRange{7, 7}));
  EXPECT_TRUE(is_valid(to_xml(document), "permissions.xsd"));
  // sros2 writes two grants, of which the second is dead.
  const auto sros2 = permissions_from(sros2_permissions(*policy, {.validity = kTemplate}));
  EXPECT_EQ(sros2->grants.size(), 2u);
}

TEST(RosPolicies, Actions_AreServicesAndTopics) {
  const auto policy = policy_from(
      {{"policy.xml", profile("<actions call=\"ALLOW\"><action>x</action></actions>")}});
  ASSERT_TRUE(policy);
  const auto grant =
      permissions_of(*policy, {.validity = kTemplate, .discovery_topic = false}).grants.at(0);
  EXPECT_EQ(names(grant.rules.at(0).publish),
            (std::vector<std::string>{"rq/n/x/_action/cancel_goalRequest",
                                      "rq/n/x/_action/get_resultRequest",
                                      "rq/n/x/_action/send_goalRequest"}));
  EXPECT_EQ(
      names(grant.rules.at(0).subscribe),
      (std::vector<std::string>{"rr/n/x/_action/cancel_goalReply", "rr/n/x/_action/get_resultReply",
                                "rr/n/x/_action/send_goalReply", "rt/n/x/_action/feedback",
                                "rt/n/x/_action/status"}));
}

}  // namespace
}  // namespace ddssec::governance
