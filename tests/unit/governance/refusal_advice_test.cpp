#include "governance/refusal_advice.hpp"

#include <gmock/gmock.h>

#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {
namespace {

using ::testing::HasSubstr;

GrantRule publishes(std::vector<std::string> topics, std::optional<std::string> partition = {},
                    std::optional<DataTag> tag = {}) {
  GrantRule out{.allow = true, .domains = {.ranges = {{0, 0}}}};
  Criteria criteria{.line = 7};
  for (auto& topic : topics) criteria.topics.push_back({std::move(topic), 0});
  if (partition) criteria.partitions = {{{*partition, 0}}};
  if (tag) criteria.data_tags = {{*tag}};
  out.publish.push_back(std::move(criteria));
  return out;
}

CompiledGrant compiled(GrantRule rule) {
  auto permissions = std::make_shared<Permissions>();
  auto& grant = permissions->grants.emplace_back();
  grant.rules.push_back(std::move(rule));
  return CompiledGrant(permissions, grant, 0);
}

RefusalAdvice advice(const CompiledGrant& grant, const Request& request) {
  return advice_on(grant, Action::publish, request, grant.judge(Action::publish, request));
}

TEST(RefusalAdvice, AllowedTopicInAnotherPartition_IsSaid) {
  const auto grant = compiled(publishes({"rt/*"}, "yard*"));
  const std::vector<std::string_view> street = {"street"};
  const auto found = advice(grant, {.topic = "rt/a", .partitions = street});
  EXPECT_EQ(found.because, "line 7 allows the topic, but only in \"yard*\"");
  EXPECT_THAT(found.hint, HasSubstr("the topic is allowed, but not in partition \"street\""));
  EXPECT_THAT(advice(grant, {.topic = "rt/a"}).hint, HasSubstr("but not without a partition"));
  const auto plain = compiled(publishes({"rt/*"}));
  EXPECT_EQ(advice(plain, {.topic = "rt/a", .partitions = street}).because,
            "line 7 allows the topic, but only without a partition (or in \"\")");
  const std::vector<std::string_view> yard = {"yard1"};
  EXPECT_EQ(advice(grant, {.topic = "rt/a", .partitions = yard}).hint, "");  // this is allowed
}

TEST(RefusalAdvice, AllowedTopicWithOtherDataTags_IsSaid) {
  const auto grant = compiled(publishes({"a"}, {}, DataTag{"colour", "red"}));
  const std::vector<DataTag> blue = {{"colour", "blue"}};
  EXPECT_THAT(advice(grant, {.topic = "a", .data_tags = blue}).hint,
              HasSubstr("not with these data tags"));
}

TEST(RefusalAdvice, NameThatIsClose_IsProposed) {
  const auto grant = compiled(publishes({"rt/chatter", "Square", "rt/*x"}));
  for (const auto* typed : {"chatter", "/chatter", "rt/chater", "rt/CHATTER", "rt/chatters"})
    EXPECT_THAT(advice(grant, {.topic = typed}).hint, HasSubstr("is \"rt/chatter\" meant?"))
        << typed;
  for (const auto* typed : {"", "a", "rt/camera", "Sq", "rt/chatter/more"})
    EXPECT_EQ(advice(grant, {.topic = typed}).hint, "") << typed;
  // Two neighbouring letters are swapped in each of them.
  for (const auto* typed : {"Sqaure", "Suqare", "Squaer"})
    EXPECT_THAT(advice(grant, {.topic = typed}).hint, HasSubstr("is \"Square\" meant?")) << typed;
  EXPECT_EQ(advice(grant, {.topic = std::string(100'000, 'a')}).hint, "");
}

TEST(RefusalAdvice, TopicOfAnotherNode_NamesTheEnclave) {
  const auto grant = compiled(publishes({"rt/chatter", "rr/b/get_parametersReply"}));
  for (const auto* topic : {"rr/a/get_parametersReply", "rq/a/list_parametersRequest"}) {
    const auto found = advice(grant, {.topic = topic});
    EXPECT_EQ(found.because, "the permissions are for the ROS 2 node \"/b\"") << topic;
    EXPECT_THAT(found.hint, HasSubstr("the node \"/a\" asks")) << topic;
    EXPECT_THAT(found.hint, HasSubstr("--enclave NAME")) << topic;
  }
  // The same node, or a grant that names no node: the name alone is compared.
  EXPECT_THAT(advice(grant, {.topic = "rr/b/get_parameterReply"}).hint, HasSubstr("meant?"));
  EXPECT_EQ(advice(compiled(publishes({"rt/x"})), {.topic = "rr/a/get_parametersReply"}).hint, "");
}

TEST(RefusalAdvice, TopicOfRos_BeginsWithThePolicy) {
  for (const auto* topic : {"rt/secret", "rq/addRequest", "rr/addReply"})
    EXPECT_THAT(hint_for_ros_topic(topic), testing::StartsWith("in a keystore of ROS 2")) << topic;
  for (const auto* topic : {"", "secret", "rt", "art/secret", "ros_discovery_info"})
    EXPECT_EQ(hint_for_ros_topic(topic), "") << topic;
}

TEST(RefusalAdvice, NameNearToAnExpression_IsProposed) {
  const auto grant = compiled(publishes({"DDSPref*", "rt/chat*", "Cam?ra"}));
  for (const auto* typed : {"DDSPerfRDataKS", "ddsprefA", "DDSPrfX", "DDPSrefX"})
    EXPECT_THAT(advice(grant, {.topic = typed}).hint,
                HasSubstr("is a name that \"DDSPref*\" matches meant?"))
        << typed;
  for (const auto* typed : {"chatter", "/chatter", "rt/Chatter", "rt/chtter"})
    EXPECT_EQ(advice(grant, {.topic = typed}).because, "\"rt/chat*\" is allowed") << typed;
  for (const auto* typed : {"DDSOther", "rt/camera", "Square", "", "Comara"})
    EXPECT_EQ(advice(grant, {.topic = typed}).hint, "") << typed;
  const auto other = compiled(publishes({"*x", "?", "[ab]cdefgh*"}));
  EXPECT_EQ(advice(other, {.topic = "xcdefghi"}).hint, "");
  EXPECT_EQ(advice(compiled(publishes({std::string(129, 'a') + "*"})), {.topic = "b"}).hint, "");
}

TEST(RefusalAdvice, DenyRules_AreNotMentioned) {
  auto rule = publishes({"a"}, "p");
  rule.allow = false;
  const auto grant = compiled(rule);
  const std::vector<std::string_view> p = {"p"};
  EXPECT_EQ(advice(grant, {.topic = "a", .partitions = p}).hint, "");
}

}  // namespace
}  // namespace ddssec::governance
