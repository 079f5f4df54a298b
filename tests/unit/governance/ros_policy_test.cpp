#include "governance/ros_policy.hpp"

#include <map>

#include <fmt/format.h>

#include "governance/write.hpp"
#include "pki/source.hpp"
#include "tests/support/test_data.hpp"
#include "tests/unit/governance/schema.hpp"

namespace ddssec::governance {
namespace {

using namespace std::chrono;

/// What sros2's template says if nobody gives dates.
constexpr Validity kTemplate{sys_days(2020y / May / 1), sys_days(2030y / May / 1)};

std::string data_text(const std::string& name) {
  return std::string(as_text(data_file("sros2/" + name)));
}

Result<Bytes> from_data(const std::filesystem::path& file) {
  return pki::load("file://" + file.string(), "", 1 << 20);
}

Result<RosPolicy> policy_of(const std::string& name) {
  return read_ros_policy(test::data_path("sros2/" + name), from_data);
}

/// A policy made of files in memory; the first one is read.
Result<RosPolicy> policy_from(const std::map<std::string, std::string>& files,
                              const std::string& first = "policy.xml") {
  return read_ros_policy(first, [&](const std::filesystem::path& path) -> Result<Bytes> {
    const auto found = files.find(path.string());
    if (found == files.end()) return fail(Code::file_not_found, {.document = path});
    return to_bytes(as_bytes(found->second));
  });
}

/// A policy of one enclave with this inside its <profile>.
std::string profile(std::string_view inside, std::string_view ns = "/n") {
  return fmt::format(
      "<policy version=\"0.2.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"><enclaves>"
      "<enclave path=\"/e\"><profiles><profile ns=\"{}\" node=\"m\">{}</profile></profiles>"
      "</enclave></enclaves></policy>",
      ns, inside);
}

struct Golden {
  const char *policy, *expected;
  bool discovery;
};
class Sros2Golden : public ::testing::TestWithParam<Golden> {};

TEST_P(Sros2Golden, IsTheSameOctetForOctet) {
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

TEST(RosNames, AreExpandedAsTheNodeMeansThem) {
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

TEST(RosPolicies, OfSeveralProfilesAreMergedAndDenialsWin) {
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
  EXPECT_TRUE(grant.rules[0].publish.empty() && grant.rules[0].subscribe.empty());
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

TEST(RosPolicies, ActionsAreServicesAndTopics) {
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

TEST(RosPolicies, IncludeFromBelowTheirFolder) {
  const std::string include = "<xi:include href=\"sub/a.xml\" xpointer=\"xpointer(/profile/*)\"/>";
  const std::string topics = "<topics publish=\"ALLOW\"><topic>x</topic></topics>";
  const std::string a =
      "<profile xmlns:y=\"http://www.w3.org/2003/XInclude\"><y:include href=\"b.xml\" "
      "xpointer=\"xpointer(/profile/*)\"/></profile>";
  const auto policy = policy_from({{"policy.xml", profile(include)},
                                   {"sub/a.xml", a},
                                   {"sub/b.xml", "<profile>" + topics + "</profile>"}});
  ASSERT_TRUE(policy) << policy.error().to_sentence();
  ASSERT_EQ(policy->enclaves[0].profiles[0][0].elements.size(), 1u);
}

TEST(RosPolicies, IncludeWholeEnclaves) {
  const std::string outer =
      "<policy version=\"0.2.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"><enclaves>"
      "<xi:include href=\"in.xml\" xpointer=\"xpointer(/policy/enclaves/*)\"/></enclaves></policy>";
  const auto inner = profile("<topics publish=\"ALLOW\"><topic>x</topic></topics>");
  const auto policy = policy_from({{"policy.xml", outer}, {"in.xml", inner}});
  ASSERT_TRUE(policy) << policy.error().to_sentence();
  EXPECT_EQ(policy->enclaves.at(0).path, "/e");
}

TEST(RosPolicies, IncludesAreBounded) {
  for (const char* href : {"/etc/passwd", "../a.xml", "sub/../../a.xml", "http://x/a.xml", ""})
    EXPECT_CODE(
        policy_from({{"policy.xml", profile(fmt::format("<xi:include href=\"{}\" "
                                                        "xpointer=\"xpointer(/profile/*)\"/>",
                                                        href))}}),
        policy_include);
  for (const char* xpointer : {"", "xpointer(/)", "xpointer(/*)", "xpointer(//a/*)", "/profile/*",
                               "xpointer(/other/*)", "xpointer(/profile/@a/*)"})
    EXPECT_CODE(policy_from({{"policy.xml", profile(fmt::format("<xi:include href=\"a.xml\" "
                                                                "xpointer=\"{}\"/>",
                                                                xpointer))},
                             {"a.xml",
                              "<profile><topics publish=\"ALLOW\"><topic>x</topic></topics>"
                              "</profile>"}}),
                policy_include);
  const std::string itself = "<xi:include href=\"a.xml\" xpointer=\"xpointer(/profile/*)\"/>";
  const auto loop =
      "<profile xmlns:xi=\"http://www.w3.org/2001/XInclude\">" + itself + "</profile>";
  EXPECT_CODE(policy_from({{"policy.xml", profile(itself)}, {"a.xml", loop}}), policy_include);
  const auto large = "<profile>" + std::string(9'000'000, ' ') + "<topics/></profile>";
  EXPECT_CODE(policy_from({{"policy.xml", profile(itself + itself)}, {"a.xml", large}}),
              xml_too_large);
  EXPECT_CODE(policy_from({{"policy.xml", profile("<xi:include href=\"none.xml\" "
                                                  "xpointer=\"xpointer(/profile/*)\"/>")}}),
              file_not_found);
}

struct Bad {
  const char *name, *from, *to;
  Code code;
};
class BadRosPolicy : public ::testing::TestWithParam<Bad> {};

TEST_P(BadRosPolicy, IsRefused) {
  const auto& [name, from, to, code] = GetParam();
  const auto good = profile("<topics publish=\"ALLOW\"><topic>x</topic></topics>");
  const auto policy = policy_from({{"policy.xml", pki::replaced(good, from, to)}});
  ASSERT_FALSE(policy) << name;
  EXPECT_EQ(policy.error().code(), code) << policy.error().to_sentence();
  EXPECT_EQ(policy.error().details().document, "policy.xml");
}

INSTANTIATE_TEST_SUITE_P(
    All, BadRosPolicy,
    ::testing::Values(Bad{"version", "0.2.0", "0.1.0", Code::policy_value},
                      Bad{"qualifier", "ALLOW", "allow", Code::policy_value},
                      Bad{"path", "path=\"/e\"", "path=\"e\"", Code::policy_value},
                      Bad{"namespace", "ns=\"/n\"", "ns=\"n\"", Code::policy_value},
                      Bad{"node", "node=\"m\"", "", Code::policy_value},
                      Bad{"attribute", "publish=", "call=", Code::attribute_unknown},
                      Bad{"element", "<topic>x</topic>", "<service>x</service>",
                          Code::element_unknown},
                      Bad{"list", "<topics publish=\"ALLOW\"><topic>x</topic></topics>", "<thing/>",
                          Code::element_unknown},
                      Bad{"no name", "<topic>x</topic>", "<topic/>", Code::element_empty},
                      Bad{"no names", "<topic>x</topic>", "", Code::element_missing},
                      Bad{"no profile",
                          "<profile ns=\"/n\" node=\"m\"><topics publish=\"ALLOW\"><topic>x</topic>"
                          "</topics></profile>",
                          "", Code::element_missing},
                      Bad{"text", "<enclaves>", "<enclaves>text", Code::text_unexpected},
                      Bad{"doctype", "<policy ", "<!DOCTYPE x><policy ", Code::xml_doctype},
                      Bad{"foreign include", "<topics publish=\"ALLOW\">",
                          "<a:include/><topics publish=\"ALLOW\">", Code::element_unknown}));

TEST(RosPolicies, OfAnotherKindAreRefused) {
  EXPECT_CODE(policy_from({{"policy.xml", kPermissionsXml}}), document_kind);
}

}  // namespace
}  // namespace ddssec::governance
