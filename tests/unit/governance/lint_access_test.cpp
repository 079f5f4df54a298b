// Findings about which participants may join, read and write.
#include "tests/unit/governance/governance_lint.hpp"

namespace ddssec::governance {
namespace {

using namespace testing_lint;
using enum ProtectionKind;

TopicRule open_topic(std::string expression) {
  return topic_rule_of(Profile::open, std::move(expression));
}

// Returns the findings of `id` in a strict document whose topic rule for everything was changed.
std::vector<Finding> of_topic(ddssec::Rule id, const std::function<void(TopicRule&)>& change,
                              ProtectionKind rtps = sign) {
  return of(id, changed_strict([&](DomainRule& rule) {
              rule.rtps_protection_kind = rtps;
              change(rule.topic_rules[0]);
            }));
}

TEST(LintAccess, OpenTopicsBesideProtectedOnes_AreReported) {
  const auto document = [](ProtectionKind rtps) {
    return changed_strict([&](DomainRule& rule) {
      rule.rtps_protection_kind = rtps;
      rule.topic_rules = {strict("rt/secret"), open_topic("rt/clock"), open_topic("*")};
    });
  };
  const auto found = of(ddssec::Rule::GOV040, document(none));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_TRUE(found[0].message.starts_with("\"rt/clock\": ")) << found[0].message;
  EXPECT_EQ(found[0].severity, Severity::informational) << "it may be meant";
  EXPECT_TRUE(found[1].message.starts_with("\"*\": ")) << found[1].message;
  EXPECT_EQ(found[1].severity, Severity::warning);
  EXPECT_TRUE(of(ddssec::Rule::GOV040, document(sign)).empty()) << "messages are protected";
}

TEST(LintAccess, ControlledReadingOfWhatIsOnlySigned_IsReported) {
  const auto under = [](ProtectionKind metadata, ProtectionKind data, ProtectionKind rtps,
                        bool is_controlled = true) {
    return of_topic(
        ddssec::Rule::GOV048,
        [&](TopicRule& topic) {
          topic.metadata_protection_kind = metadata;
          topic.data_protection_kind = data;
          topic.enable_read_access_control = is_controlled;
        },
        rtps);
  };
  for (const auto rtps : {none, sign, sign_with_origin_authentication}) {
    const auto found = under(sign_with_origin_authentication, none, rtps);
    ASSERT_EQ(found.size(), 1u);
    EXPECT_TRUE(found[0].message.contains("every host on the network can read"));
  }
  const auto inside = under(none, sign, encrypt);
  ASSERT_EQ(inside.size(), 1u);
  EXPECT_TRUE(inside[0].message.contains("each participant that may join can read"));
  EXPECT_TRUE(under(encrypt, none, none).empty());
  EXPECT_TRUE(under(sign, encrypt, none).empty());
  EXPECT_TRUE(under(sign, none, none, false).empty());
  EXPECT_TRUE(under(none, none, none).empty()) << "GOV043 says so";
}

TEST(LintAccess, WritingThatNothingControls_IsReportedWhereReadingIsControlled) {
  const auto with = [](bool reading, bool writing, ProtectionKind data) {
    return of_topic(ddssec::Rule::GOV049, [&](TopicRule& topic) {
      topic.enable_read_access_control = reading;
      topic.enable_write_access_control = writing;
      topic.metadata_protection_kind = none;
      topic.data_protection_kind = data;
    });
  };
  EXPECT_EQ(with(true, false, encrypt).size(), 1u);
  EXPECT_TRUE(with(true, true, encrypt).empty());
  EXPECT_TRUE(with(false, false, encrypt).empty()) << "GOV041 says so";
  EXPECT_TRUE(with(true, false, none).empty()) << "GOV043 says so";
}

TEST(LintAccess, PermissionsWithoutEffect_AreReported) {
  const auto with = [](bool join, bool write, ProtectionKind kind) {
    return of(ddssec::Rule::GOV050, changed_strict([&](DomainRule& rule) {
                rule.enable_join_access_control = join;
                rule.rtps_protection_kind = rule.discovery_protection_kind = kind;
                rule.liveliness_protection_kind = none;
                auto topic = open_topic("*");
                topic.enable_write_access_control = write;
                rule.topic_rules = {topic};
              }));
  };
  EXPECT_EQ(with(false, false, encrypt).size(), 1u);
  EXPECT_TRUE(with(true, false, encrypt).empty());
  EXPECT_TRUE(with(false, true, encrypt).empty()) << "GOV021 says so";
  EXPECT_TRUE(with(false, false, none).empty()) << "GOV040 says so";
}

}  // namespace
}  // namespace ddssec::governance
