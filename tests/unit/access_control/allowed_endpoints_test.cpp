#include "plugins/access_control/allowed_endpoints.hpp"

#include <algorithm>
#include <ctime>

#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

using Partitions = std::vector<std::string_view>;

TEST(AllowedEndpoints, ManyEndpoints_TheNewestStayAndWildcardsMeetNames) {
  AllowedEndpoints announced;
  const auto meets = [&](const Partitions& ours) {
    const auto all = announced.of_topic(Action::publish, "t");
    return std::ranges::count_if(
        all, [&](const auto& one) { return one->partitions.overlap(PartitionNames(ours)); });
  };
  const Partitions a = {"a"}, star = {"a*"}, other = {"b", ""};
  announced.note(Action::publish, {.topic_name = "t", .partitions = a});
  announced.note(Action::publish, {.topic_name = "t", .partitions = a});
  EXPECT_EQ(meets(a), 1);
  EXPECT_EQ(meets(star), 1);
  EXPECT_EQ(meets(other), 0);
  EXPECT_EQ(meets({}), 0);
  announced.note(Action::publish, {.topic_name = "t", .partitions = star});
  EXPECT_EQ(meets(star), 2);
  EXPECT_EQ(meets(Partitions{"?"}), 1);  // two expressions do not overlap unless they are equal
  announced.note(Action::publish, {.topic_name = "t"});
  EXPECT_EQ(meets(other), 1);
  EXPECT_TRUE(announced.of_topic(Action::subscribe, "t").empty());
  EXPECT_TRUE(announced.of_topic(Action::publish, "u").empty());
  const std::string large(AllowedEndpoints::kMaxOctets, 'x');
  announced.note(Action::publish, {.topic_name = large, .partitions = a});
  EXPECT_TRUE(announced.of_topic(Action::publish, large).empty());
  for (std::size_t i = 0; i < AllowedEndpoints::kMax; ++i)
    announced.note(Action::publish, {.topic_name = std::to_string(i)});
  EXPECT_EQ(meets(star), 0);
  EXPECT_EQ(announced.of_topic(Action::publish, "0").size(), 1u);
}

// A compiled expression takes many times as much memory as its text.
TEST(AllowedEndpoints, Memory_IsBoundedAndTheNewestStays) {
  AllowedEndpoints announced;
  const auto note = [&](char c) {
    std::string name;
    while (name.size() < 1'000) name += "[ab]";
    name.back() = c;
    const std::vector<std::string_view> names(4, name);
    announced.note(Action::publish, {.topic_name = "t", .partitions = names});
  };
  for (char c = 'a'; c <= 'z'; ++c) note(c);
  const auto all = announced.of_topic(Action::publish, "t");
  ASSERT_FALSE(all.empty());
  std::size_t octets = 0;
  for (const auto& one : all) octets += one->octets();
  EXPECT_LE(octets, AllowedEndpoints::kMaxMemory);
  EXPECT_GT(octets, AllowedEndpoints::kMaxMemory / 2);
  note('!');
  EXPECT_TRUE(
      announced.of_topic(Action::publish, "t").front()->partitions.views().front().ends_with('!'));
}

// Our participant, and a peer that may do everything in every partition.
class HostilePartitions : public AccessControlTest {
 protected:
  void SetUp() override { ASSERT_TRUE(local(open_permissions(kTalker))); }
  spi::PermissionsHandle peer(std::vector<governance::GrantRule> rules) {
    return remote(signed_permissions({grant(kListener, std::move(rules))})).value();
  }
  // The process's own processor time is measured, because a busy machine changes it little.
  static double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

  // The largest announcement that is remembered, full of what makes the compiler of expressions
  // slow.
  struct Announcement {
    explicit Announcement(char number) {
      for (const std::string unit : {"[:", "[[=", "[[.", "*["}) {
        std::string& name = texts.emplace_back();
        while (name.size() < 1'000) name += unit;
        name += number;
      }
      names.assign(texts.begin(), texts.end());
    }
    std::vector<std::string> texts;
    Partitions names;
  };
};

// Without these limits, 32 endpoints with such partitions, matched one after the other, occupy a
// process for an hour.
TEST_F(HostilePartitions, ManyEndpoints_AreCompiledOnceAndQuickly) {
  auto all = subscribe_rule(true, {"t"});
  all.subscribe[0].partitions = {{{"*", 0}}};
  const auto handle = peer({all});
  const auto begin = cpu_seconds();
  for (char number = '0'; number < '0' + 32; ++number) {
    const Announcement announced(number);
    ASSERT_TRUE(plugin->check_remote_datareader(
        handle, 0, {.topic_name = "t", .partitions = announced.names}));
    const Partitions ours = {"some/partition", "another"};
    EXPECT_TRUE(
        plugin->check_remote_match(handle, {.remote_writes = false,
                                            .local = {.topic_name = "t", .partitions = ours},
                                            .remote = std::nullopt}));
    ASSERT_LT(cpu_seconds() - begin, 1) << number;
  }
}

TEST_F(HostilePartitions, DenyRules_AreComparedQuickly) {
  auto denied = subscribe_rule(false, {"t"});
  denied.subscribe[0].partitions.emplace();
  for (int i = 0; i < 100; ++i)
    denied.subscribe[0].partitions->push_back({"private" + std::to_string(i), 0});
  auto all = subscribe_rule(true, {"t"});
  all.subscribe[0].partitions = {{{"*", 0}}};
  const auto handle = peer({denied, all});
  const auto begin = cpu_seconds();
  for (char number = '0'; number < '0' + 32; ++number) {
    const Announcement announced(number);
    ASSERT_TRUE(plugin->check_remote_datareader(
        handle, 0, {.topic_name = "t", .partitions = announced.names}));
    ASSERT_LT(cpu_seconds() - begin, 1) << number;
  }
  const Partitions secret = {"private7"}, perhaps = {"priv*7"};
  EXPECT_REFUSED(
      plugin->check_remote_datareader(handle, 0, {.topic_name = "t", .partitions = secret}),
      announced_reader_not_allowed);
  EXPECT_REFUSED(
      plugin->check_remote_datareader(handle, 0, {.topic_name = "t", .partitions = perhaps}),
      announced_reader_not_allowed);
}

TEST_F(HostilePartitions, PartitionsBeyondTheBounds_AreRefusedOfPeersOnly) {
  auto all = rule(true);
  all.publish = {topics({"*"})};
  all.publish[0].partitions = {{{"*", 0}}};
  all.subscribe = all.publish;
  const auto handle = peer({all});
  const std::string longer(kMaxNameOctets + 1, 'a');
  const Partitions partitions = {"", longer};
  const spi::EndpointRequest request = {.topic_name = "t", .partitions = partitions};
  EXPECT_REFUSED(plugin->check_remote_datawriter(handle, 0, request), length_out_of_range);
  EXPECT_REFUSED(plugin->check_remote_datareader(handle, 0, request), length_out_of_range);
  EXPECT_REFUSED(plugin->check_remote_datawriter(handle, 0, {.topic_name = longer}),
                 length_out_of_range);
  EXPECT_REFUSED(plugin->check_remote_topic(handle, 0, longer), length_out_of_range);
  const auto own = local(signed_permissions({grant(kTalker, {all})})).value();
  EXPECT_TRUE(plugin->check_create_datawriter(own, 0, request));
}

TEST(AllowedEndpoints, Lengths_AreBounded) {
  const auto code = [](std::string_view topic, const Partitions& partitions) {
    const auto status = check_lengths({.topic_name = topic, .partitions = partitions});
    return status ? std::nullopt : std::optional(status.error().code());
  };
  const std::string longest(kMaxNameOctets, 'a'), longer(kMaxNameOctets + 1, 'a');
  EXPECT_EQ(code(longest, {longest, "b"}), std::nullopt);
  EXPECT_EQ(code("t", Partitions(kMaxPartitions, "p")), std::nullopt);
  EXPECT_EQ(code("t", Partitions(kMaxRequestOctets / (kMaxNameOctets + 1), longest)), std::nullopt);
  EXPECT_EQ(code(longer, {}), Code::length_out_of_range);
  EXPECT_EQ(code("t", {"b", longer}), Code::length_out_of_range);
  EXPECT_EQ(code("t", Partitions(kMaxPartitions + 1, "")), Code::length_out_of_range);
  EXPECT_EQ(code("t", Partitions(kMaxRequestOctets / kMaxNameOctets, longest)),
            Code::length_out_of_range);
  // A data tag costs two octets besides its name and value.
  std::vector<Property> tags(2, Property{"n", std::string((kMaxRequestOctets - 7) / 2, 'v')});
  EXPECT_TRUE(check_lengths({.topic_name = "t", .data_tags = tags}));
  tags[0].value += "vv";
  const auto refused = check_lengths({.topic_name = "t", .data_tags = tags});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::length_out_of_range);
}

}  // namespace
}  // namespace ddssec::access_control
