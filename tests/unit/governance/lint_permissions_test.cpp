#include <algorithm>
#include <ctime>
#include <functional>

#include "governance/lint.hpp"
#include "governance/profile.hpp"
#include "governance/rights.hpp"
#include "governance/write.hpp"
#include "tests/unit/governance/fixture.hpp"

namespace ddssec::governance {
namespace {

const pki::Certificate& certificate() {
  static const auto made = make_leaf(pki::make_ca(), "CN=talker,O=A\\, B,C=DE").certificate;
  return made;
}

Rights rights(std::vector<std::string> publish, std::vector<std::string> subscribe = {}) {
  return {.domains = {{0, 0}}, .publish = std::move(publish), .subscribe = std::move(subscribe)};
}

Grant grant_for(const Rights& rights) {
  return grant_of("talker", certificate(), rights,
                  {certificate().not_before(), certificate().not_after()});
}

/// Written and read again, so that it has lines.
Permissions read_again(const Permissions& document) {
  auto again = permissions_from(to_xml(document));
  EXPECT_TRUE(again) << again.error().to_sentence();
  return *std::move(again);
}
Permissions with(const Rights& rights) { return read_again({.grants = {grant_for(rights)}}); }
Permissions changed(const std::function<void(Grant&)>& change, const Rights& base = rights({"a"})) {
  auto grant = grant_for(base);
  change(grant);
  return read_again({.grants = {std::move(grant)}});
}

Rule rule(bool allow, std::vector<std::string> publish, std::vector<std::string> subscribe = {}) {
  auto out = grant_for(rights(std::move(publish), std::move(subscribe))).rules.at(0);
  out.allow = allow;
  return out;
}
Permissions with_rules(std::vector<Rule> rules) {
  return changed([&](Grant& grant) { grant.rules = std::move(rules); });
}

/// Everything but PERM026, which many short documents of these tests have besides.
std::vector<Finding> lint_but_joining(const Permissions& document, const PermissionsUse& use = {}) {
  auto found = lint(document, use);
  std::erase_if(found, [](const Finding& f) { return f.rule == ddssec::Rule::PERM026; });
  return found;
}

/// The only finding of the whole document.
Finding only(const Permissions& document, const PermissionsUse& use = {}) {
  const auto found = lint_but_joining(document, use);
  EXPECT_EQ(found.size(), 1u);
  for (const auto& finding : found) {
    EXPECT_TRUE(finding.path.starts_with("/dds/permissions")) << finding.path;
    EXPECT_GT(finding.line, 0);
    if (found.size() > 1) ADD_FAILURE() << info(finding.rule).id << ' ' << finding.message;
  }
  return found.empty() ? Finding{ddssec::Rule::end_, ""} : found.front();
}

TEST(LintPermissions, OfACertificateWithSomeRightsHaveNothing) {
  const auto document = with(rights({"a", "b*"}, {"c"}));
  EXPECT_TRUE(lint_but_joining(document).empty());
  const auto governance = governance_of(Profile::strict, {{0, 0}});
  EXPECT_TRUE(lint_but_joining(document, {pki::kNow, &certificate(), &governance}).empty());
}

// DDS-Security 1.2 table 70.
TEST(LintPermissions, ADenialOfTopicsBeforeTheRuleThatLetsJoin) {
  const auto allow = rule(true, {"b"}), deny = rule(false, {"a"});
  const auto found = lint(with_rules({deny, allow}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].rule, ddssec::Rule::PERM026);
  EXPECT_TRUE(found[0].message.starts_with("the first rule for domain 0 is a deny_rule"));
  EXPECT_EQ(found[0].severity, Severity::informational);
  EXPECT_TRUE(lint(with_rules({rule(true, {}), deny, allow})).empty());
  EXPECT_TRUE(lint(with_rules({allow, deny})).size() <= 1u);
}

TEST(LintPermissions, Dates) {
  const auto document = with(rights({"a"}));
  const auto ended = only(document, {.now = certificate().not_after()});
  EXPECT_EQ(ended.rule, ddssec::Rule::PERM002);
  EXPECT_EQ(ended.severity, Severity::error);
  const auto early = only(document, {.now = certificate().not_before() - std::chrono::seconds(1)});
  EXPECT_EQ(early.rule, ddssec::Rule::PERM002);
  EXPECT_EQ(early.severity, Severity::warning);
  const auto longer = changed([](Grant& g) { g.validity.not_after += std::chrono::hours(1); });
  EXPECT_EQ(only(longer, {.certificate = &certificate()}).rule, ddssec::Rule::PERM002);
  EXPECT_TRUE(lint_but_joining(longer).empty());
}

TEST(LintPermissions, AValidityOfASecondOrLess) {
  using std::chrono::seconds;
  const auto lasting = [](seconds time) {
    return changed([&](Grant& g) { g.validity.not_after = g.validity.not_before + time; });
  };
  const auto never = only(lasting(seconds(0)));
  EXPECT_EQ(never.rule, ddssec::Rule::PERM002);
  EXPECT_EQ(never.severity, Severity::error);
  EXPECT_TRUE(never.message.starts_with("the grant is never valid: it begins and ends at "));
  const auto once = only(lasting(seconds(1)));
  EXPECT_EQ(once.severity, Severity::warning);
  EXPECT_TRUE(once.message.starts_with("the grant is valid for one second only, at "));
  EXPECT_TRUE(lint_but_joining(lasting(seconds(2))).empty());
}

TEST(LintPermissions, ExpressionsThatMatchNoName) {
  const auto dead = [](const Permissions& document) {
    auto found = lint(document);
    std::erase_if(found, [](const Finding& f) { return f.rule != ddssec::Rule::PERM012; });
    return found;
  };
  auto found = dead(with_rules({rule(true, {"[z-a]", "b"})}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::warning);
  EXPECT_EQ(found[0].message,
            "to publish \"[z-a]\" can never apply in allow_rule 1: no name matches "
            "\"[z-a]\"");
  EXPECT_EQ(found[0].hint, "write what the expression is meant to match, or delete it");
  found = dead(with_rules({rule(true, {}), rule(false, {"[z-a]"}), rule(true, {"*"})}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].severity, Severity::error) << "nothing is denied";
  auto partitioned = rule(false, {"a"});
  partitioned.publish[0].partitions = {{"p\\", 0}};
  found = dead(with_rules({rule(true, {}), partitioned, rule(true, {"*"})}));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].message, "a <partition> can never apply: no name matches \"p\\\"");
  EXPECT_EQ(found[0].severity, Severity::error);
  const auto subject = [](const char* text) {
    return changed([&](Grant& g) {
      g.subject_is_expression = true;
      g.subject_name = text;
    });
  };
  found = dead(subject("CN=[/a]"));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].message, "the grant can never apply: no name matches \"CN=[/a]\"");
  EXPECT_TRUE(dead(subject("CN=[\\\\a]*")).empty());
}

// A newcomer's list of denials must not take minutes, and what was not looked at is said.
TEST(LintPermissions, RulesThatTakeTooLongToCompareAreTold) {
  std::vector<Rule> rules;
  for (int i = 0; i < 400; ++i)
    rules.push_back(rule(false, {(i % 2 ? "*a" : "*b") + std::string(i % 40, '?')}));
  rules.push_back(rule(true, {"*"}));
  const auto begin = std::clock();
  const auto found = lint_but_joining(with_rules(std::move(rules)));
  EXPECT_LT(std::clock() - begin,
            10 * CLOCKS_PER_SEC);  // of a processor; 1 s, without the bound 10 s
  EXPECT_TRUE(std::ranges::any_of(found, [](const Finding& f) {
    return f.rule == ddssec::Rule::PERM012 && f.message.contains("take too long to compare");
  }));
}

TEST(LintPermissions, PartitionsThatProductsReadDifferently) {
  const auto in = [](const char* partition) {
    auto allowed = rule(true, {"a"});
    allowed.publish[0].partitions = {{partition, 0}};
    return with_rules({allowed});
  };
  const auto found = only(in("[^a]"));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM013);
  EXPECT_EQ(found.vendors, std::vector<std::string>{"cyclonedds"});
  EXPECT_TRUE(lint_but_joining(in("[a]")).empty());
}

TEST(LintPermissions, ASecondGrantIsDead) {
  auto grant = grant_for(rights({"a"}));
  auto other = grant;
  other.subject_name = "C=DE, O=\"A, B\", CN=talker";
  auto found = lint_but_joining(read_again({.grants = {grant, other}}));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].rule, ddssec::Rule::PERM011);
  EXPECT_EQ(found[1].rule, ddssec::Rule::PERM010);
  EXPECT_EQ(found[1].severity, Severity::error);
  EXPECT_EQ(found[1].path, "/dds/permissions/grant[2]");
  other.subject_name = "CN=listener";
  EXPECT_TRUE(lint_but_joining(read_again({.grants = {grant, other}})).empty());
}

TEST(LintPermissions, ARenewedGrantIsDeadForCycloneOnly) {
  auto grant = grant_for(rights({"a"}));
  auto next = grant;
  next.validity = {grant.validity.not_after, grant.validity.not_after + std::chrono::hours(1)};
  const auto found = only(read_again({.grants = {grant, next}}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM010);
  EXPECT_EQ(found.severity, Severity::warning);
  EXPECT_EQ(found.vendors, std::vector<std::string>{"cyclonedds"});
}

struct Subject {
  const char *text, *right;
  std::vector<std::string> vendors;
};
class SubjectSpelling : public ::testing::TestWithParam<Subject> {};

// As measured with both vendors.
TEST_P(SubjectSpelling, IsCorrected) {
  const auto& [text, right, vendors] = GetParam();
  const auto found = only(changed([&](Grant& g) { g.subject_name = text; }));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM011);
  EXPECT_EQ(found.hint, std::string("write <subject_name>") + right + "</subject_name>");
  EXPECT_EQ(found.vendors, vendors);
}

using Vendors = std::vector<std::string>;
const Vendors kFastDdsOnly = {"fastdds"}, kCycloneOnly = {"cyclonedds"},
              kBoth = {"cyclonedds", "fastdds"};

INSTANTIATE_TEST_SUITE_P(
    All, SubjectSpelling,
    ::testing::Values(Subject{"C=DE,O=Acme,CN=pub", "CN=pub,O=Acme,C=DE", kFastDdsOnly},
                      Subject{"/C=DE/O=Acme/CN=pub", "CN=pub,O=Acme,C=DE", kFastDdsOnly},
                      Subject{"CN=pub, O=Acme, C=DE", "CN=pub,O=Acme,C=DE", kCycloneOnly},
                      Subject{"CN=pub , O=\"A, B\"", "CN=pub,O=A\\, B", kBoth},
                      Subject{"CN = pub", "CN=pub", kBoth}, Subject{"cn=pub", "CN=pub", kBoth},
                      Subject{"2.5.4.3=pub", "CN=pub", kBoth},
                      Subject{"commonName=pub", "CN=pub", kBoth},
                      Subject{"CN=\"pub\"", "CN=pub", kBoth},
                      Subject{"CN=\\70ub", "CN=pub", kBoth}));

TEST(LintPermissions, SubjectsThatAreFine) {
  for (const char* text : {"CN=pub", "CN=pub,O=Acme,C=DE", "CN=/a/b", "CN=pub,O=A\\, B", "CN=a b"})
    EXPECT_TRUE(lint_but_joining(changed([&](Grant& g) { g.subject_name = text; })).empty())
        << text;
  EXPECT_EQ(only(changed([](Grant& g) { g.subject_name = "talker"; })).severity, Severity::error);
}

TEST(LintPermissions, OfAnotherSubjectThanTheCertificates) {
  const auto document = changed([](Grant& g) { g.subject_name = "CN=talker2,O=A\\, B,C=DE"; });
  const auto found = only(document, {.certificate = &certificate()});
  EXPECT_EQ(found.rule, ddssec::Rule::PERM011);
  EXPECT_EQ(found.severity, Severity::error);
  EXPECT_EQ(found.hint, "write <subject_name>CN=talker,O=A\\, B,C=DE</subject_name>");
}

TEST(LintPermissions, OfTheSubjectInOtherWords) {
  const auto document = changed([](Grant& g) { g.subject_name = "C=DE,O=A\\, B,CN=talker"; });
  const auto found = only(document, {.certificate = &certificate()});
  EXPECT_EQ(found.rule, ddssec::Rule::PERM011);
  EXPECT_EQ(found.severity, Severity::warning);
}

TEST(LintPermissions, ADenyRuleBehindWhatItDeniesIsAnError) {
  const auto found = only(with_rules({rule(true, {"rt*"}), rule(false, {"rtb", "rta*"})}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM012);
  EXPECT_EQ(found.severity, Severity::error);
  EXPECT_EQ(found.message,
            "deny_rule 2 can never apply: to publish \"rtb\", \"rt*\" (allow_rule 1, line 16) "
            "already decides for every name it matches");
  EXPECT_EQ(found.path, "/dds/permissions/grant[1]/deny_rule[1]");
}

TEST(LintPermissions, DeadPartsOfARuleAreNamedOneByOne) {
  const auto found = only(with_rules({rule(false, {"a*"}), rule(true, {"b", "ab"})}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM012);
  EXPECT_EQ(found.severity, Severity::warning);
  EXPECT_TRUE(found.message.starts_with("to publish \"ab\" can never apply in allow_rule 2"));
  EXPECT_EQ(only(with(rights({"a*", "ab"}))).severity, Severity::informational);
}

// What another domain, partition or data tag needs is not dead.
TEST(LintPermissions, DeadNeedsTheSameCircumstances) {
  auto first = rule(true, {"*"}), second = rule(true, {"a"});
  second.domains.ranges = {{0, 1}};
  EXPECT_TRUE(lint_but_joining(with_rules({first, second})).empty());
  first.domains.ranges = {{0, 0}, {1, 5}};
  EXPECT_EQ(only(with_rules({first, second})).rule, ddssec::Rule::PERM012);
  second.publish[0].data_tags = std::vector<DataTag>{{"x", "y"}};
  for (const auto& finding : lint_but_joining(with_rules({first, second})))
    EXPECT_EQ(finding.rule, ddssec::Rule::PERM014);
}

TEST(LintPermissions, PartitionsOfDeadRules) {
  const auto dead = [](std::vector<std::string> earlier, bool earlier_allows,
                       std::vector<std::string> later, bool later_allows) {
    auto a = rule(earlier_allows, {"*"}), b = rule(later_allows, {"a"});
    const auto set = [](Rule& r, const auto& names) {
      if (names.empty()) return;
      r.publish[0].partitions.emplace();
      for (const auto& name : names) r.publish[0].partitions->push_back({name, 0});
    };
    set(a, earlier), set(b, later);
    const auto found = lint_but_joining(with_rules({a, b}));
    return std::ranges::any_of(found,
                               [](const Finding& f) { return f.rule == ddssec::Rule::PERM012; });
  };
  EXPECT_TRUE(dead({}, false, {"x"}, true));
  EXPECT_TRUE(dead({}, false, {"x"}, false));
  EXPECT_FALSE(dead({}, true, {"x"}, true));
  EXPECT_TRUE(dead({}, true, {}, false));  // who has partitions is denied by default
  EXPECT_TRUE(dead({}, true, {"x"}, false));
  EXPECT_TRUE(dead({"x*"}, true, {"xy", "xz"}, true));
  EXPECT_FALSE(dead({"x*"}, true, {"xy", "z"}, true));
  EXPECT_FALSE(dead({"x*"}, true, {"xy"}, false));
  EXPECT_TRUE(dead({"x*"}, false, {"xy"}, true));
  EXPECT_TRUE(dead({"x*"}, false, {"xy"}, false));
  EXPECT_FALSE(dead({"x*"}, false, {}, true));
  EXPECT_FALSE(dead({"x*"}, false, {}, false));
}

TEST(LintPermissions, ExpressionsThatProductsReadDifferently) {
  const auto found = only(with(rights({"rt[^a]"})));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM013);
  EXPECT_EQ(found.path, "/dds/permissions/grant[1]/allow_rule[1]");
}

TEST(LintPermissions, WhatStockProductsPassOver) {
  auto tagged = rule(true, {"a"});
  tagged.publish[0].data_tags = std::vector<DataTag>{{"x", "y"}};
  EXPECT_EQ(only(with_rules({tagged})).rule, ddssec::Rule::PERM014);
  auto relay = rule(true, {"a"});
  relay.relay = relay.publish;
  EXPECT_EQ(only(with_rules({relay})).severity, Severity::informational);
}

TEST(LintPermissions, RulesThatDifferInPartitionsOnly) {
  auto first = rule(true, {"a*"}), second = rule(true, {"ab"});
  second.publish[0].partitions = std::vector<Text>{{"x", 0}};
  const auto found = only(with_rules({first, second}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM015);
  EXPECT_EQ(found.vendors, std::vector<std::string>{"fastdds"});
}

TEST(LintPermissions, PartitionsThatDifferWithinOneRule) {
  auto joined = rule(true, {"a"});
  joined.publish.push_back(joined.publish[0]);
  joined.publish[1].topics = {{"b", 0}};
  EXPECT_TRUE(lint_but_joining(with_rules({joined})).empty());
  joined.publish[1].partitions = std::vector<Text>{{"x", 0}};
  const auto found = only(with_rules({joined}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM015);
  EXPECT_EQ(found.vendors, std::vector<std::string>{"fastdds"});
  EXPECT_EQ(found.message,
            "\"b\": other partitions than for \"a\" in the same rule, and Fast DDS allows each "
            "topic of a rule in the partitions of all its elements");
}

TEST(LintPermissions, DeniedInOneDirectionAndAllowedInTheOther) {
  const auto found = only(with_rules({rule(false, {"rtc*"}), rule(true, {}, {"rt*"})}));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM020);
  EXPECT_EQ(found.vendors, std::vector<std::string>{"cyclonedds"});
  EXPECT_EQ(found.message,
            "deny_rule 1 denies to publish \"rtc\", and a later allow_rule allows to subscribe it: "
            "Cyclone DDS refuses the topic altogether");
  EXPECT_EQ(only(with_rules({rule(false, {}, {"a"}), rule(true, {"a"})})).rule,
            ddssec::Rule::PERM020);
  // Denied both ways, or named by an allow_rule before.
  EXPECT_TRUE(
      lint_but_joining(with_rules({rule(false, {"a"}, {"a"}), rule(true, {"b"}, {"?"})})).empty());
  EXPECT_TRUE(lint_but_joining(with_rules({rule(true, {}, {"a"}), rule(false, {"a"})})).empty());
}

TEST(LintPermissions, DenialsAndPartitions) {
  auto deny = rule(false, {"a"});
  deny.publish[0].partitions = std::vector<Text>{{"x", 0}};
  const auto listed = only(with_rules({deny, rule(true, {"b"})}));
  EXPECT_EQ(listed.rule, ddssec::Rule::PERM021);
  EXPECT_EQ(listed.vendors, std::vector<std::string>{"fastdds"});
  auto allow = rule(true, {"*"});
  allow.publish[0].partitions = std::vector<Text>{{"x", 0}};
  const auto open = only(with_rules({rule(false, {"a"}), allow}));
  EXPECT_EQ(open.rule, ddssec::Rule::PERM021);
  EXPECT_EQ(open.vendors, std::vector<std::string>{"cyclonedds"});
}

// Measured with Cyclone DDS 0.10.2: the first rule that names the topic decides about all of it.
TEST(LintPermissions, DenialInOnePartition_RefusesTheTopicInCyclone) {
  auto deny = rule(false, {"a"}, {"a"});
  for (auto* list : {&deny.publish, &deny.subscribe})
    list->front().partitions = std::vector<Text>{{"x", 0}};
  const auto found = lint_but_joining(with_rules({deny, rule(true, {"*"}, {"*"})}));
  const auto is_cyclones = [](const Finding& finding) {
    return finding.rule == ddssec::Rule::PERM021 &&
           finding.vendors == std::vector<std::string>{"cyclonedds"};
  };
  const auto told = std::ranges::find_if(found, is_cyclones);
  ASSERT_NE(told, found.end());
  EXPECT_EQ(told->message,
            "deny_rule 1 lists partitions: Cyclone DDS refuses the topic \"a\" altogether, also in "
            "partitions that a later rule allows");
  const auto named_before =
      lint_but_joining(with_rules({rule(true, {"a"}), deny, rule(true, {"*"}, {"*"})}));
  EXPECT_TRUE(std::ranges::none_of(named_before, is_cyclones));
}

TEST(LintPermissions, DefaultsAndGrantsThatAllowNothing) {
  EXPECT_EQ(only(changed([](Grant& g) { g.default_allow = true; })).rule, ddssec::Rule::PERM022);
  EXPECT_EQ(only(with_rules({rule(false, {"a"})})).rule, ddssec::Rule::PERM023);
}

TEST(LintPermissions, WhatTheGovernanceDocumentDoesNotHave) {
  auto governance = governance_of(Profile::strict, {{0, 3}, {5, 5}});
  auto wide = rule(true, {"a"});
  wide.domains.ranges = {{2, 6}};
  const auto domains = only(with_rules({wide}), {.governance = &governance});
  EXPECT_EQ(domains.rule, ddssec::Rule::PERM024);
  EXPECT_NE(domains.message.find("domain 4, 6"), std::string::npos);
  governance.domain_rules[0].topic_rules[0].topic_expression = "x/*";
  EXPECT_EQ(only(with(rights({"y/a", "x/a", "?/*"})), {.governance = &governance}).rule,
            ddssec::Rule::PERM025);
}

const char* const kDiscovery = "ros_discovery_info";

/// Without PERM040, which ros_node_test.cpp is about.
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

TEST(LintPermissions, HalvesOfServices) {
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

TEST(LintPermissions, DiscoveryAndLogTopicsOfRos) {
  const auto found = lint_of_topics(rights({"rt/chatter"}));
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].rule, ddssec::Rule::PERM032);
  EXPECT_EQ(found[1].message, "to subscribe ros_discovery_info is not allowed");
  EXPECT_EQ(only_of_topics(rights({"rt/robot1/rosout", kDiscovery}, {kDiscovery})).rule,
            ddssec::Rule::PERM033);
  EXPECT_TRUE(
      lint_of_topics(rights({"rt/robot1/rosout", "rt/*", kDiscovery}, {kDiscovery})).empty());
}

TEST(LintPermissions, NamesThatATerminalShowsInAnotherWay) {
  const auto topic = only(with(rights({"Square\xe2\x80\xae", "Circle"})));
  EXPECT_EQ(topic.rule, ddssec::Rule::PERM041);
  EXPECT_NE(topic.message.find("holds U+202E"), std::string::npos) << topic.message;
  const auto partition = only(changed([](Grant& grant) {
    grant.rules.at(0).publish.at(0).partitions = {
        {Text{"\xc2\x9b"
              "2J",
              0}}};
  }));
  EXPECT_NE(partition.message.find("the partition"), std::string::npos);
  EXPECT_NE(partition.message.find("U+009B"), std::string::npos);
  EXPECT_EQ(only(changed([](Grant& grant) { grant.name = "a\xe2\x80\x8f"; })).rule,
            ddssec::Rule::PERM041);
  EXPECT_TRUE(lint_but_joining(with(rights({"Stra\xc3\x9f"
                                            "e"})))
                  .empty());
}

TEST(LintPermissions, SubjectBeyondAscii_NamesTheProductThatDoesNotRecogniseIt) {
  for (const auto& [subject, vendor] :
       {std::pair{"CN=caf\xc3\xa9", "cyclonedds"}, std::pair{"CN=caf\\C3\\A9", "fastdds"}}) {
    const auto found = only(changed([&](Grant& grant) { grant.subject_name = subject; }));
    EXPECT_EQ(found.rule, ddssec::Rule::PERM011);
    EXPECT_EQ(found.vendors, std::vector<std::string>{vendor});
  }
  EXPECT_TRUE(
      lint_but_joining(changed([](Grant& grant) { grant.subject_name = "CN=cafe"; })).empty());
}

TEST(LintPermissions, NamesOfRos) {
  EXPECT_EQ(only(with(rights({"/chatter"}))).rule, ddssec::Rule::PERM034);
}

struct Spelling {
  const char *from, *to;
  ddssec::Rule id;
};
class SpellingOfPermissions : public ::testing::TestWithParam<Spelling> {};

TEST_P(SpellingOfPermissions, IsFoundAtItsLine) {
  const auto& [from, to, id] = GetParam();
  const auto xml = to_xml(Permissions{.grants = {grant_for(rights({"a"}))}});
  const auto document = permissions_from(replaced(xml, from, to));
  ASSERT_TRUE(document) << document.error().to_sentence();
  EXPECT_EQ(only(*document).rule, id);
}

INSTANTIATE_TEST_SUITE_P(
    All, SpellingOfPermissions,
    ::testing::Values(Spelling{"<default>DENY</default>", "", ddssec::Rule::PERM001},
                      Spelling{" name=\"talker\"", "", ddssec::Rule::PERM001},
                      Spelling{"Z</not_after>", "</not_after>", ddssec::Rule::PERM003},
                      Spelling{"<id>0</id>", "<id_range><max>0</max></id_range>",
                               ddssec::Rule::PERM004},
                      Spelling{">a<", ">a <", ddssec::Rule::PERM005},
                      Spelling{"<id>0</id>", "<id>0</id><tag></tag>", ddssec::Rule::PERM006}));

}  // namespace
}  // namespace ddssec::governance
