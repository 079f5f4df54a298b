// Documents that are made to take long. The work is counted, and above the limit the answer is
// "unknown".
#include <ctime>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "governance/compare/governance_diff.hpp"
#include "governance/compare/permissions_diff.hpp"
#include "tests/support/slowdown.hpp"

namespace ddssec::governance {
namespace {

// The limit is generous, because this also runs without optimisation and on busy machines.
constexpr double kMaxSeconds = 40;

// One shape of expressions. A document has half a megabyte of them.
struct Shape {
  const char* name;
  std::string (*expression)(std::mt19937& random);
};
void PrintTo(const Shape& shape, std::ostream* out) { *out << shape.name; }

std::string letters(std::mt19937& random, int count) {
  std::string out;
  for (int i = 0; i < count; ++i) out += static_cast<char>('a' + random() % 8);
  return out;
}

// Each name that one of them matches is compared with all of them, from each of its places.
std::string repeated_letter(std::mt19937& random) {
  return "*" + std::string(200 + random() % 1800, 'a') + "*b";
}

std::string many_stars(std::mt19937& random) {
  std::string out = "*";
  for (int i = 0; i < 60; ++i) out += letters(random, 3) + "*";
  return out;
}

std::string long_and_mixed(std::mt19937& random) {
  constexpr const char* kSteps[] = {"?", "a", "*", "[ab]"};
  std::string out = "*";
  for (int i = 0; i < 20'000; ++i) out += kSteps[random() % std::size(kSteps)];
  return out;
}

std::vector<std::string> expressions(const Shape& shape, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::string> out;
  for (std::size_t octets = 0; octets < 500'000; octets += out.back().size())
    out.push_back(shape.expression(random));
  return out;
}

double cpu_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

template <class Document>
void expect_unknown_soon(const Document& before, const Document& after) {
  const auto start = cpu_seconds();
  const auto verdict = compare(before, after).verdict;
  EXPECT_LT(cpu_seconds() - start, test::kSlowdown * kMaxSeconds) << "of this process alone";
  EXPECT_EQ(verdict, ChangeClass::unknown) << "no gate lets it pass";
}

class HostileDocuments : public ::testing::TestWithParam<Shape> {};

TEST_P(HostileDocuments, HostileGovernance_IsUnknownWithinSeconds) {
  const auto document = [](unsigned seed) {
    DomainRule rule;
    rule.domains.ranges = {{0, 0}};
    for (auto& expression : expressions(GetParam(), seed)) {
      rule.topic_rules.emplace_back().topic_expression = std::move(expression);
      rule.topic_rules.back().data_protection_kind = ProtectionKind::encrypt;
    }
    Governance out;
    out.domain_rules = {std::move(rule)};
    return out;
  };
  expect_unknown_soon(document(1), document(2));
}

TEST_P(HostileDocuments, HostilePermissions_AreUnknownWithinSeconds) {
  const auto document = [](unsigned seed) {
    GrantRule rule{.allow = true};
    rule.domains.ranges = {{0, 0}};
    rule.publish.emplace_back();
    for (auto& expression : expressions(GetParam(), seed))
      rule.publish.back().topics.push_back({std::move(expression)});
    Grant grant{.subject_name = "CN=talker",
                .validity = {WallTime(), WallTime(std::chrono::days(1))},
                .rules = {std::move(rule)}};
    Permissions out;
    out.grants = {std::move(grant)};
    return out;
  };
  expect_unknown_soon(document(1), document(2));
}

INSTANTIATE_TEST_SUITE_P(Shapes, HostileDocuments,
                         ::testing::Values(Shape{"RepeatedLetter", repeated_letter},
                                           Shape{"ManyStars", many_stars},
                                           Shape{"LongAndMixed", long_and_mixed}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace ddssec::governance
