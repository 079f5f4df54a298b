// The comparison of a thousand rules with a thousand rules takes well under a second of one core
// when optimised.
#include <ctime>

#include <gtest/gtest.h>

#include "governance/compare/governance_diff.hpp"
#include "governance/compare/permissions_diff.hpp"
#include "tests/support/slowdown.hpp"

namespace ddssec::governance {
namespace {

constexpr std::size_t kRules = 1000;
// The limit is generous, because this also runs without optimisation and on busy machines.
constexpr double kMaxSeconds = 20;

// One shape of expressions, made from a rule's number.
struct Shape {
  const char* name;
  std::string (*expression)(std::size_t);
};
void PrintTo(const Shape& shape, std::ostream* out) { *out << shape.name; }

std::string mixed(std::size_t i) {
  const auto n = std::to_string(i);
  switch (i % 5) {
    case 0:
      return "rt/a" + n + "*";
    case 1:
      return "rt/b" + n + "/*/x";
    case 2:
      return "*_" + n + "Reply";
    case 3:
      return "rt/[a-f]_" + n + "?";
    default:
      return "rt/lit" + n;
  }
}

const Shape kShapes[] = {
    {"literals", [](std::size_t i) { return "rt/robot" + std::to_string(i) + "/pose"; }},
    {"beginnings", [](std::size_t i) { return "rt/robot" + std::to_string(i) + "/*"; }},
    {"endings", [](std::size_t i) { return "*/robot" + std::to_string(i) + "/pose"; }},
    {"parts", [](std::size_t i) { return "*/robot" + std::to_string(i) + "/*"; }},
    {"services", [](std::size_t i) { return "rq/*/node" + std::to_string(i) + "/*Request"; }},
    {"mixed", mixed}};

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

class Speed : public ::testing::TestWithParam<Shape> {};

Governance governance(const Shape& shape, std::size_t from) {
  DomainRule rule;
  rule.domains.ranges = {{0, 0}};
  for (std::size_t i = from; i < from + kRules; ++i) {
    TopicRule topic;
    topic.topic_expression = shape.expression(i);
    topic.data_protection_kind = static_cast<ProtectionKind>(i * 7 % 3);
    rule.topic_rules.push_back(topic);
  }
  Governance document;
  document.domain_rules = {rule};
  return document;
}

Permissions permissions(const Shape& shape, std::size_t from) {
  Grant grant{.subject_name = "CN=talker",
              .validity = {WallTime(), WallTime(std::chrono::days(1))}};
  for (std::size_t i = from; i < from + kRules; ++i) {
    GrantRule rule{.allow = i % 10 != 0};
    rule.domains.ranges = {{0, 0}};
    rule.publish = {{.topics = {{shape.expression(i)}}}};
    grant.rules.push_back(rule);
  }
  Permissions document;
  document.grants = {grant};
  return document;
}

template <class Document>
void expect_quick(const Document& before, const Document& after) {
  const auto start = cpu_seconds();
  const auto diff = compare(before, after);
  const auto seconds = cpu_seconds() - start;
  EXPECT_EQ(diff.verdict, ChangeClass::mixed);
  EXPECT_LT(seconds, test::kSlowdown * kMaxSeconds);
  ::testing::Test::RecordProperty("seconds", std::to_string(seconds));
}

TEST_P(Speed, AThousandTopicRulesAgainstAThousand_TakeLessThanTheLimit) {
  expect_quick(governance(GetParam(), 0), governance(GetParam(), 500));
}

TEST_P(Speed, AThousandPermissionRulesAgainstAThousand_TakeLessThanTheLimit) {
  expect_quick(permissions(GetParam(), 0), permissions(GetParam(), 500));
}

INSTANTIATE_TEST_SUITE_P(Shapes, Speed, ::testing::ValuesIn(kShapes),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace ddssec::governance
