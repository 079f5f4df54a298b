#include "governance/doctor/subject_form.hpp"

#include "doctor_fixture.hpp"

namespace ddssec::governance::doctor {
namespace {

constexpr auto kOk = Outcome::ok;
constexpr auto kFail = Outcome::fail;
constexpr auto kUnsafe = Outcome::unsafe;

struct Row {
  std::string_view text;
  Outcomes outcomes;
};

// Measured with the products themselves: tests/interop/doctor_test.py has the same forms.
TEST(SubjectForm, EachProduct_ReadsSomeOfThem) {
  const auto ca = make_ca("CN=CA");
  const auto leaf = make_leaf(ca, "CN=pub,O=Acme,C=DE");
  ASSERT_EQ(leaf.certificate.subject(), "CN=pub,O=Acme,C=DE");
  for (const auto& [text, outcomes] : {
           Row{"CN=pub,O=Acme,C=DE", {kOk, kOk, kOk}},
           Row{"  CN=pub,O=Acme,C=DE ", {kOk, kOk, kOk}},
           Row{"CN=pub,O=Acme,C=DE\n", {kOk, kFail, kOk}},
           Row{"\n\tCN=pub,O=Acme,C=DE", {kOk, kFail, kOk}},
           Row{"CN=pub,O=Acme,C=DE,", {kUnsafe, kOk, kFail}},
           Row{"CN=pub,O=Acme,C=DE,,,", {kUnsafe, kOk, kFail}},
           Row{"CN=pub,O=Acme,C=DE ,", {kFail, kOk, kFail}},
           Row{"CN=pub,O=Acme,C=DE, ", {kUnsafe, kFail, kFail}},
           Row{"CN=pub,O=Acme,C=DE,,L=Bonn", {kUnsafe, kUnsafe, kFail}},
           Row{"CN=pub,,O=Acme,C=DE", {kUnsafe, kFail, kFail}},
           Row{",CN=pub,O=Acme,C=DE", {kUnsafe, kFail, kFail}},
           Row{" , CN=pub,O=Acme,C=DE", {kFail, kFail, kFail}},
           Row{"C=DE,O=Acme,CN=pub", {kOk, kFail, kOk}},
           Row{"/C=DE/O=Acme/CN=pub", {kOk, kFail, kOk}},
           Row{"O=Acme,CN=pub,C=DE", {kOk, kFail, kFail}},
           Row{"CN=pub, O=Acme, C=DE", {kFail, kOk, kOk}},
           Row{"C = DE, O = Acme, CN = pub", {kFail, kFail, kOk}},
           Row{"cn=pub,o=Acme,c=DE", {kFail, kFail, kOk}},
           Row{"CN=pub", {kFail, kFail, kFail}},
           Row{"CN=pub,O=Acme,C=DE,L=Bonn", {kUnsafe, kFail, kFail}},
           Row{"L=Bonn|CN=pub|O=Acme|C=DE", {kUnsafe, kFail, kFail}},
           Row{"CN=pub,CN=other,O=Acme,C=DE", {kUnsafe, kFail, kFail}},
           Row{"CN=other,CN=pub,O=Acme,C=DE", {kFail, kFail, kFail}},
           Row{"CN=pub,O=Acme,C=DE, L=Bonn", {kUnsafe, kFail, kFail}},
           Row{"CN=Pub,O=Acme,C=DE", {kFail, kFail, kFail}},
           Row{"", {kFail, kFail, kFail}},
           Row{"no name at all", {kFail, kFail, kFail}},
       })
    EXPECT_EQ(reads_subject(text, leaf.certificate), outcomes) << text;
}

TEST(SubjectForm, LaterFastDds_ReadsPartsInAnyOrderAndBlanks) {
  const auto leaf = make_leaf(make_ca("CN=CA"), "CN=pub,O=Acme,C=DE");
  const auto reads = [&](std::string_view text) {
    return reads_subject(text, leaf.certificate, {.fastdds = {3, 1, 2}}).fastdds;
  };
  for (const auto* text : {"CN=pub,O=Acme,C=DE", "C=DE,O=Acme,CN=pub", "O=Acme,CN=pub,C=DE",
                           "CN=pub, O=Acme, C=DE", "C = DE, O = Acme, CN = pub"})
    EXPECT_EQ(reads(text), kOk) << text;
  for (const auto* text : {"/C=DE/O=Acme/CN=pub", "cn=pub,o=Acme,c=DE", "CN=pub", "CN=pub,O=Acme,C",
                           "CN=Pub,O=Acme,C=DE", ""})
    EXPECT_EQ(reads(text), kFail) << text;
}

// Measured with Fast DDS 3.1.2.
TEST(SubjectForm, LaterFastDds_EndsAtAPartWithoutEquals) {
  const auto leaf = make_leaf(make_ca("CN=CA"), "CN=pub,O=Acme,C=DE");
  const auto reads = [&](std::string_view text) {
    return reads_subject(text, leaf.certificate, {.fastdds = {3, 1, 2}}).fastdds;
  };
  for (const auto* text : {"CN=pub,O=Acme,C=DE,", "CN=pub,O=Acme,C=DE,,,", "CN=pub,O=Acme,C=DE, "})
    EXPECT_EQ(reads(text), kOk) << text;
  for (const auto* text : {"CN=pub,O=Acme,C=DE,x", "CN=pub,O=Acme,C=DE,,L=Bonn"})
    EXPECT_EQ(reads(text), kUnsafe) << text;
  for (const auto* text : {",CN=pub,O=Acme,C=DE", "CN=pub,,O=Acme,C=DE",
                           "CN=pub,O=Acme,C=DE,L=", "x,CN=pub,O=Acme,C=DE", "CN=pub,O=Acme,C=DE\n"})
    EXPECT_EQ(reads(text), kFail) << text;
}

TEST(SubjectForm, AnEscapedComma_SeparatesNothing) {
  const auto ca = make_ca("CN=CA");
  const auto leaf = make_leaf(ca, "CN=pub,O=Acme\\, Inc.");
  EXPECT_TRUE(reads_subject(leaf.certificate.subject(), leaf.certificate).all_ok())
      << leaf.certificate.subject();
  EXPECT_EQ(reads_subject("CN=pub,O=Acme", leaf.certificate), Outcomes::all(kFail));
}

}  // namespace
}  // namespace ddssec::governance::doctor
