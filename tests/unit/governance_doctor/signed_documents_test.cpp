// Form, signature and text of the two signed documents.
#include <gmock/gmock.h>

#include "doctor_fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class DiagnoseDocuments : public Folders {
 protected:
  // Returns the message of the only finding.
  std::string only(Rule rule) const {
    const auto all = diagnosis(folder_);
    EXPECT_THAT(rules_of(all), ElementsAre(rule));
    return finding_of(all, rule).message;
  }
  std::string governance_xml() const { return to_xml(strict_governance()); }

  const pki::ParticipantFolder folder_ = participant("talker");
};

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return at == text.npos ? text : text.replace(at, from.size(), to);
}

TEST_F(DiagnoseDocuments, TextThatIsNotSigned_IsNamedByItsForm) {
  write(folder_.governance, governance_xml());
  EXPECT_THAT(only(Rule::DOC030),
              AllOf(HasSubstr("governance.p7s is"), HasSubstr("it must be multipart/signed")));
}

TEST_F(DiagnoseDocuments, TextThatWasEditedAfterwards_FailsForAll) {
  write(folder_.permissions, replaced(read(folder_.permissions), "Square", "Circle"));
  EXPECT_THAT(only(Rule::DOC031), HasSubstr("permissions.p7s: "));
  EXPECT_EQ(diagnosis(folder_).outcomes(), Outcomes::all(Outcome::fail));
}

TEST_F(DiagnoseDocuments, AnotherCasSignature_NamesBothCas) {
  const auto other = make_ca("CN=Another CA");
  const auto signed_by_other = other.sign_document(as_bytes(governance_xml()), kNow, test_random());
  ASSERT_TRUE(signed_by_other);
  write(folder_.governance, std::string(as_text(*signed_by_other)));
  EXPECT_THAT(only(Rule::DOC032), AllOf(HasSubstr("was signed by \"CN=Another CA\""),
                                        HasSubstr("holds \"CN=Permissions CA\" (serial ")));
  EXPECT_EQ(diagnosis(folder_).outcomes(), Outcomes::all(Outcome::fail));
}

TEST_F(DiagnoseDocuments, XmlThatCannotBeRead_HasItsLine) {
  sign(folder_.governance, replaced(governance_xml(), "</dds>", ""));
  EXPECT_THAT(only(Rule::DOC036), HasSubstr("governance.p7s: "));
  EXPECT_GT(finding_of(diagnosis(folder_), Rule::DOC036).line, 1);
}

TEST_F(DiagnoseDocuments, ASignedTextWithoutOctets_IsSaidToBeEmpty) {
  sign(folder_.permissions, "");
  EXPECT_THAT(only(Rule::DOC036), HasSubstr("the signed document is empty, 0 octets"));
}

TEST_F(DiagnoseDocuments, SpellingThatAProductRefuses_IsSaidOnceWithItsNumber) {
  auto governance = strict_governance();
  auto& rules = governance.domain_rules[0].topic_rules;
  rules.insert(rules.begin(), {.topic_expression = "Square"});
  const std::string kind = "<metadata_protection_kind>";
  const auto once = replaced(to_xml(governance), kind + "ENCRYPT", kind + "encrypt");
  sign(folder_.governance, once);
  EXPECT_THAT(only(Rule::DOC037), AllOf(HasSubstr(kind), Not(HasSubstr("other place"))));
  sign(folder_.governance, replaced(once, kind + "ENCRYPT", kind + "encrypt"));
  EXPECT_THAT(only(Rule::DOC037), HasSubstr("(and at 1 other place)"));
}

TEST_F(DiagnoseDocuments, XmlBesideTheDocument_IsReportedIfItSaysSomethingElse) {
  const auto beside = folder_.folder / "governance.xml";
  write(beside, governance_xml());
  EXPECT_THAT(rules_of(diagnosis(folder_)), IsEmpty());
  write(beside, governance_xml() + "\r\n\n");  // an editor ends lines and files otherwise
  EXPECT_THAT(rules_of(diagnosis(folder_)), IsEmpty());
  write(beside, replaced(governance_xml(), "SIGN", "NONE"));
  EXPECT_THAT(only(Rule::DOC038), AllOf(HasSubstr("governance.xml says something else than"),
                                        HasSubstr("governance.p7s, which is what counts")));
  EXPECT_TRUE(diagnosis(folder_).outcomes().all_ok());
}

TEST_F(DiagnoseDocuments, RevisionThatSigningAdds_IsNoDifference) {
  const auto revised = replaced(governance_xml(), "?>", "?>\n<?ddssec revision=\"7\"?>");
  sign(folder_.governance, revised);
  write(folder_.folder / "governance.xml", governance_xml());
  EXPECT_THAT(rules_of(diagnosis(folder_)), Not(Contains(Rule::DOC038)));
}

TEST_F(DiagnoseDocuments, AFolderBesideTheDocument_IsNoText) {
  fs::create_directory(folder_.folder / "governance.xml");
  EXPECT_THAT(rules_of(diagnosis(folder_)), IsEmpty());
}

}  // namespace
}  // namespace ddssec::governance::doctor
