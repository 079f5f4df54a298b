// Whether Fast DDS would start with a profile, and with security.
#include <gmock/gmock.h>

#include "governance/doctor/configuration_checks.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Pair;
using testing::UnorderedElementsAre;

const std::string kPki = "dds.sec.auth.builtin.PKI-DH.";
const std::string kAccess = "dds.sec.access.builtin.Access-Permissions.";

// What a secured participant has, in the order in which it is judged.
ProfileProperties secured() {
  return {{"dds.sec.auth.plugin", "builtin.PKI-DH"},
          {"dds.sec.access.plugin", "builtin.Access-Permissions"},
          {"dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC"},
          {kPki + "identity_ca", "file:///a/ca"},
          {kPki + "identity_certificate", "file:///a/cert"},
          {kPki + "private_key", "file:///a/key"},
          {kAccess + "permissions_ca", "file:///a/pca"},
          {kAccess + "governance", "file:///a/g"},
          {kAccess + "permissions", "file:///a/p"}};
}
constexpr std::size_t kPlugins = 3;

std::string participant(const ProfileProperties& properties,
                        const std::string& attributes = " is_default_profile=\"true\"",
                        const std::string& name = "one") {
  std::string out = "<participant profile_name=\"" + name + "\"" + attributes +
                    ">\n<rtps><propertiesPolicy><properties>";
  for (const auto& [property, value] : properties)
    out += "<property><name>" + property + "</name><value>" + value + "</value></property>";
  return out + "</properties></propertiesPolicy></rtps></participant>";
}
std::string profiles(const std::string& inside) { return "<profiles>\n" + inside + "</profiles>"; }

Diagnosis judged(const std::string& text) {
  Diagnosis out;
  diagnose_profile(
      {.name = "fastdds.xml", .document = "/a/fastdds.xml", .text = text, .version = {2, 9, 1}},
      out);
  return out;
}
std::vector<Finding> findings(const Diagnosis& diagnosis) {
  std::vector<Finding> out;
  for (const auto& check : diagnosis.checks())
    out.insert(out.end(), check.findings.begin(), check.findings.end());
  return out;
}
std::vector<Rule> rules_of(const std::string& text) {
  std::vector<Rule> out;
  for (const auto& finding : findings(judged(text))) out.push_back(finding.rule);
  return out;
}
// The one finding about the text, which only Fast DDS is to have.
void expect_finding(const std::string& text, Rule rule, Outcome outcome, const std::string& words) {
  const auto diagnosis = judged(text);
  const auto found = findings(diagnosis);
  ASSERT_EQ(found.size(), 1u) << text;
  EXPECT_EQ(found[0].rule, rule) << found[0].message;
  EXPECT_THAT(found[0].message, HasSubstr("fastdds.xml"));
  EXPECT_THAT(found[0].message, HasSubstr(words));
  EXPECT_EQ(found[0].document, "/a/fastdds.xml");
  EXPECT_THAT(found[0].products, ElementsAre("fastdds@2.9.1"));
  EXPECT_EQ(diagnosis.outcomes().fastdds, outcome) << found[0].message;
  EXPECT_EQ(diagnosis.outcomes().cyclonedds, Outcome::ok);
  EXPECT_EQ(diagnosis.outcomes().ddssec, Outcome::ok);
}

TEST(CheckFastDds, WholeProfile_PassesAllThreeChecks) {
  for (const auto& text :
       {profiles(participant(secured())), "<dds>" + profiles(participant(secured())) + "</dds>"}) {
    const auto diagnosis = judged(text);
    EXPECT_THAT(findings(diagnosis), IsEmpty()) << text;
    ASSERT_EQ(diagnosis.checks().size(), 3u);
    EXPECT_EQ(diagnosis.outcomes().fastdds, Outcome::ok);
  }
}

TEST(CheckFastDds, NoDefaultParticipant_RunsWithoutSecurity) {
  for (const auto& text :
       {profiles(""), profiles(participant(secured(), "")),
        profiles(participant(secured(), " is_default_profile=\"false\"")), std::string("<dds/>")})
    expect_finding(text, Rule::DOC101, Outcome::fail, "runs without security");
}

TEST(CheckFastDds, MissingOrMisspeltPlugin_IsReported) {
  for (std::size_t i = 0; i < kPlugins; ++i) {
    const auto outcome = i == 0 ? Outcome::fail : Outcome::unsafe;
    const auto words = i == 0 ? "runs without security" : "does not apply all of the documents";
    auto properties = secured();
    const auto name = properties[i].first;
    properties[i].second += ' ';
    expect_finding(profiles(participant(properties)), Rule::DOC101, outcome,
                   "has the property " + name);
    expect_finding(profiles(participant(properties)), Rule::DOC101, outcome, words);
    properties.erase(properties.begin() + static_cast<std::ptrdiff_t>(i));
    expect_finding(profiles(participant(properties)), Rule::DOC101, outcome,
                   "has no property " + name);
  }
}

TEST(CheckFastDds, EachMissingOrEmptyDocument_DoesNotStart) {
  for (auto i = kPlugins; i < secured().size(); ++i) {
    auto properties = secured();
    const auto words = "names no " + properties[i].first + ", so that Fast DDS does not start";
    properties[i].second.clear();
    EXPECT_THAT(rules_of(profiles(participant(properties))), Contains(Rule::DOC102)) << words;
    properties.erase(properties.begin() + static_cast<std::ptrdiff_t>(i));
    expect_finding(profiles(participant(properties)), Rule::DOC102, Outcome::fail, words);
  }
}

TEST(CheckFastDds, LastPropertyOfAName_CountsBesideTheDoubt) {
  const std::pair<std::string, std::string> wrong{"dds.sec.auth.plugin", "none"};
  auto properties = secured();
  properties.insert(properties.begin(), wrong);
  expect_finding(profiles(participant(properties)), Rule::DOC108, Outcome::fail,
                 "has the property dds.sec.auth.plugin twice");
  properties = secured();
  properties.push_back(wrong);
  EXPECT_THAT(rules_of(profiles(participant(properties))),
              UnorderedElementsAre(Rule::DOC101, Rule::DOC108));
}

TEST(CheckFastDds, TextThatIsNotWellFormed_RunsWithoutSecurity) {
  for (const auto* text : {"", "<profiles>", "<profiles></dds>", "<profiles><?x y?></profiles>"})
    expect_finding(text, Rule::DOC101, Outcome::fail, "cannot be read");
}

TEST(CheckFastDds, UnknownElement_IsADoubt) {
  expect_finding(profiles(participant(secured()) + "<unheard_of/>"), Rule::DOC108, Outcome::fail,
                 "it is not known that Fast DDS 2.9.1 accepts this");
}

TEST(PropertiesOfProfile, LastDefaultParticipant_IsReadWithItsBlanks) {
  const auto text =
      profiles(participant({{"a", "1"}}) +
               participant({{" b", "2 "}, {"c", ""}}, " is_default_profile=\"true\"", "two") +
               participant({{"d", "3"}}, "", "three"));
  const auto found = properties_of_profile(text);
  ASSERT_TRUE(found);
  EXPECT_THAT(*found, ElementsAre(Pair(" b", "2 "), Pair("c", "")));
}

TEST(PropertiesOfProfile, NoDefaultParticipant_HasNone) {
  for (const auto& text : {std::string(), std::string("<profiles>"), profiles(""),
                           profiles(participant(secured(), "")), participant(secured()),
                           "<other>" + profiles(participant(secured())) + "</other>"})
    EXPECT_FALSE(properties_of_profile(text)) << text;
}

TEST(DefaultParticipant, EachPlaceAndValue_MayBeOne) {
  for (const auto& text :
       {profiles(participant({})), profiles(participant({}, " is_default_profile=\"false\"")),
        "<dds>" + profiles(participant({})) + "</dds>", "<dds>" + participant({}) + "</dds>",
        std::string("<dds>")})
    EXPECT_TRUE(may_set_default_participant(text)) << text;
}

TEST(DefaultParticipant, WellFormedTextWithoutTheAttribute_SetsNone) {
  for (const auto& text : {std::string("<dds/>"), profiles(""), profiles(participant({}, "")),
                           profiles("<publisher is_default_profile=\"true\"/>")})
    EXPECT_FALSE(may_set_default_participant(text)) << text;
}

}  // namespace
}  // namespace ddssec::governance::doctor
