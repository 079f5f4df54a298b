// Policies of sros2 that are read, with the files that they include.
#include "tests/unit/governance/ros_policies.hpp"

namespace ddssec::governance {
namespace {

TEST(RosPolicies, FilesBelowTheirFolder_AreIncluded) {
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

TEST(RosPolicies, WholeEnclaves_AreIncluded) {
  const std::string outer =
      "<policy version=\"0.2.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"><enclaves>"
      "<xi:include href=\"in.xml\" xpointer=\"xpointer(/policy/enclaves/*)\"/></enclaves></policy>";
  const auto inner = profile("<topics publish=\"ALLOW\"><topic>x</topic></topics>");
  const auto policy = policy_from({{"policy.xml", outer}, {"in.xml", inner}});
  ASSERT_TRUE(policy) << policy.error().to_sentence();
  EXPECT_EQ(policy->enclaves.at(0).path, "/e");
}

TEST(RosPolicies, Includes_AreBounded) {
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

TEST_P(BadRosPolicy, EachFault_IsRefused) {
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

TEST(RosPolicies, DocumentOfAnotherKind_IsRefused) {
  EXPECT_CODE(policy_from({{"policy.xml", kPermissionsXml}}), document_kind);
}

}  // namespace
}  // namespace ddssec::governance
