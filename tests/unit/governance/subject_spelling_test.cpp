// Subjects that a product does not recognise, or that are not the certificate's.
#include "tests/unit/governance/permissions_lint.hpp"

namespace ddssec::governance {
namespace {

struct Subject {
  const char *text, *right;
  std::vector<std::string> products;
};
class SubjectSpelling : public ::testing::TestWithParam<Subject> {};

// Both products' products behaved like this when measured.
TEST_P(SubjectSpelling, EachSpelling_IsCorrected) {
  const auto& [text, right, products] = GetParam();
  const auto found = only(changed([&](Grant& g) { g.subject_name = text; }));
  EXPECT_EQ(found.rule, ddssec::Rule::PERM011);
  EXPECT_EQ(found.hint, std::string("write <subject_name>") + right + "</subject_name>");
  EXPECT_EQ(found.products, products);
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

TEST(SubjectFindings, CorrectSubjects_HaveNoFinding) {
  for (const char* text : {"CN=pub", "CN=pub,O=Acme,C=DE", "CN=/a/b", "CN=pub,O=A\\, B", "CN=a b"})
    EXPECT_TRUE(lint_but_joining(changed([&](Grant& g) { g.subject_name = text; })).empty())
        << text;
  EXPECT_EQ(only(changed([](Grant& g) { g.subject_name = "talker"; })).severity, Severity::error);
}

TEST(SubjectFindings, SubjectBeyondAscii_NamesTheProductThatDoesNotRecogniseIt) {
  for (const auto& [subject, product] :
       {std::pair{"CN=caf\xc3\xa9", "cyclonedds"}, std::pair{"CN=caf\\C3\\A9", "fastdds"}}) {
    const auto found = only(changed([&](Grant& grant) { grant.subject_name = subject; }));
    EXPECT_EQ(found.rule, ddssec::Rule::PERM011);
    EXPECT_EQ(found.products, std::vector<std::string>{product});
  }
  EXPECT_TRUE(
      lint_but_joining(changed([](Grant& grant) { grant.subject_name = "CN=cafe"; })).empty());
}

TEST(SubjectFindings, AnotherSubjectThanTheCertificates_IsAnError) {
  const auto document = changed([](Grant& g) { g.subject_name = "CN=talker2,O=A\\, B,C=DE"; });
  const auto found = only(document, {.certificate = &certificate()});
  EXPECT_EQ(found.rule, ddssec::Rule::PERM011);
  EXPECT_EQ(found.severity, Severity::error);
  EXPECT_EQ(found.hint, "write <subject_name>CN=talker,O=A\\, B,C=DE</subject_name>");
}

TEST(SubjectFindings, CertificatesSubjectInOtherWords_IsAWarning) {
  const auto document = changed([](Grant& g) { g.subject_name = "C=DE,O=A\\, B,CN=talker"; });
  const auto found = only(document, {.certificate = &certificate()});
  EXPECT_EQ(found.rule, ddssec::Rule::PERM011);
  EXPECT_EQ(found.severity, Severity::warning);
}

}  // namespace
}  // namespace ddssec::governance
