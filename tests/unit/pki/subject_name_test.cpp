#include "pki/subject_name.hpp"

#include "pki_fixture.hpp"
#include "tests/support/printable_subject.hpp"

namespace ddssec::pki {
namespace {

SubjectName name(std::string_view text) {
  auto out = SubjectName::parse(text);
  EXPECT_TRUE(out) << text << out.error().to_sentence();
  return *std::move(out);
}

TEST(SubjectName, DirectionAndBlanks_DoNotMatter) {
  const auto certificate = make_ca("CN=Alice B,O=Example,C=NL").certificate();
  for (const char* same :
       {"CN=Alice B,O=Example,C=NL", "C=NL,O=Example,CN=Alice B",
        " CN = Alice B , O= Example,C =NL ", "/C=NL/O=Example/CN=Alice B",
        "cn=Alice B,o=Example,c=NL", "2.5.4.3=Alice B,O=Example,C=NL",
        "CN=\"Alice B\",O=Example,C=NL", "CN=Alice\\ B,O=Example,C=NL",
        "CN=#0C07416C6963652042,O=Example,C=NL", "commonName=Alice B,O=Example,C=NL"})
    EXPECT_TRUE(name(same).matches(certificate)) << same;
  EXPECT_TRUE(name(certificate.subject()).matches(certificate));
  EXPECT_TRUE(name(certificate.subject_one_line()).matches(certificate));
}

TEST(SubjectName, EveryOtherName_Differs) {
  const auto certificate = make_ca("CN=Alice,O=Example,C=NL").certificate();
  for (const char* other :
       {"CN=Alice,O=Example", "CN=Alice,O=Example,C=NL,OU=x", "CN=alice,O=Example,C=NL",
        "CN=Alice,O=Example,C=BE", "CN=Alice,CN=Alice,O=Example,C=NL", "O=Alice,CN=Example,C=NL",
        "CN=Alice\\ ,O=Example,C=NL", "CN=Alic,O=Example,C=NL", "CN=Alice,C=NL,O=Example",
        "O=Example,CN=Alice,C=NL", "CN=Alice+O=Example,C=NL", "CN=Alice,O=Example+C=NL"}) {
    EXPECT_FALSE(name(other).matches(certificate)) << other;
    EXPECT_NE(name(other).key(), SubjectName::of(certificate).key()) << other;
  }
}

// In X.501 a name is a sequence of RDNs, and an RDN is a set. A subordinate CA may name its own
// subjects only, so a permutation may be the name of a subject of another CA.
TEST(SubjectName, OrderOfSetsCounts_AndWithinASetDoesNot) {
  const struct {
    const char *a, *b;
    bool same;
  } kPairs[] = {{"CN=cam,OU=lab,OU=plant", "CN=cam,OU=plant,OU=lab", false},
                {"CN=cam,OU=lab,OU=plant", "OU=plant,OU=lab,CN=cam", true},
                {"CN=cam,OU=lab,OU=plant", "/OU=plant/OU=lab/CN=cam", true},
                {"CN=cam,OU=lab,OU=plant", "/OU=lab/OU=plant/CN=cam", false},
                {"CN=cam,OU=lab,OU=plant", "/CN=cam/OU=lab/OU=plant", true},
                {"O=a+OU=b", "OU=b+O=a", true},
                {"O=a+OU=b", "OU=b,O=a", false},
                {"O=a+OU=b", "O=a,OU=b", false},
                {"O=a+OU=b", "/O=a+OU=b", true},
                {"O=a+OU=b", "/O=a/OU=b", false},
                {"CN=x,O=a+OU=b", "OU=b+O=a,CN=x", true},
                {"CN=x,O=a+OU=b", "O=a+CN=x,OU=b", false},
                {"CN=x,CN=x,O=a", "CN=x,O=a,CN=x", false},
                {"CN=x", "CN=x,CN=x", false},
                {"CN=a:1+O=b", "CN=a:1,O=b", false}};
  for (const auto& [a, b, same] : kPairs) {
    EXPECT_EQ(name(a).matches(name(b)), same) << a << " | " << b;
    EXPECT_EQ(name(b).matches(name(a)), same) << a << " | " << b;
    EXPECT_EQ(name(a).key() == name(b).key(), same) << a << " | " << b;
  }
}

TEST(SubjectName, APlusInOneLine_JoinsOnlyBeforeAType) {
  EXPECT_EQ(name("/CN=a+b").rdns(), (std::vector<Rdn>{{{"CN", "a+b"}}}));
  EXPECT_EQ(name("/CN=a\\+OU=b").rdns(), (std::vector<Rdn>{{{"CN", "a+OU=b"}}}));
  EXPECT_EQ(name("/O=c/CN=a+OU=b").rdns(),
            (std::vector<Rdn>{{{"O", "c"}}, {{"CN", "a"}, {"OU", "b"}}}));
  EXPECT_CODE(SubjectName::parse("+CN=a"), subject_name_malformed);
}

TEST(SubjectName, ASlash_MayBePartOfAValue) {
  const auto certificate = make_ca("CN=/talker_listener/talker").certificate();
  EXPECT_TRUE(name("CN=/talker_listener/talker").matches(certificate));
  EXPECT_TRUE(name("/CN=/talker_listener/talker").matches(certificate));
  EXPECT_TRUE(name("/CN=\\/talker_listener\\/talker").matches(certificate));
  EXPECT_TRUE(name(certificate.subject_one_line()).matches(certificate));
  // Text that looks like another attribute is read as one, so the ambiguous text does not match the
  // certificate.
  const auto trick = make_ca("CN=a/O=b").certificate();
  EXPECT_FALSE(name("/CN=a/O=b").matches(trick));
  EXPECT_TRUE(name(trick.subject()).matches(trick));
}

TEST(SubjectName, EscapesAndMultiValuedRdns_SurviveTheCertificate) {
  for (const char* text : {"CN=a\\,b,O=c", "CN=a\\+b+OU=x\\=y,O=\\\"q\\\"", "CN=\\#a,O=b\\\\c",
                           "CN=Fr\\C3\\A4ulein,O=x", "CN=\\ a\\ ", "CN=a\\;b\\<c\\>",
                           "emailAddress=a@b.c,CN=x", "UID=u,DC=example,DC=org"}) {
    const auto certificate = make_ca(text).certificate();
    EXPECT_TRUE(name(text).matches(certificate)) << text;
    EXPECT_TRUE(name(certificate.subject()).matches(certificate)) << certificate.subject();
  }
  const auto joined = make_ca("CN=a+OU=b,O=c").certificate();
  EXPECT_NE(joined.subject().find('+'), std::string::npos);
  const auto of = SubjectName::of(joined);
  EXPECT_TRUE(of.is_joined(2));
  EXPECT_TRUE(of.is_root_first());
  EXPECT_TRUE(name("OU=b+CN=a,O=c").matches(joined));
  EXPECT_FALSE(name("OU=b,CN=a,O=c").matches(joined));
  EXPECT_TRUE(name("/O=c/CN=a+OU=b").matches(joined));
}

TEST(SubjectName, SameTextInAnotherStringType_IsToldApart) {
  const auto certificate = make_ca("CN=Alice,O=Example").certificate();
  const auto other = test::with_printable(certificate, "Alice");
  EXPECT_EQ(other.subject(), certificate.subject());
  EXPECT_NE(other.subject_digest(), certificate.subject_digest());
  EXPECT_EQ(subject_with_types(certificate), "CN=UTF8STRING:Alice,O=UTF8STRING:Example");
  EXPECT_EQ(subject_with_types(other), "CN=PRINTABLESTRING:Alice,O=UTF8STRING:Example");
  EXPECT_TRUE(name("CN=Alice,O=Example").matches(other)) << "permissions name a text";
}

TEST(SubjectName, OtherTexts_AreRefused) {
  for (const std::string text :
       {"",          "  ",        "Alice",    "=Alice",  "CN",         "NoSuchType=x", "CN=a,",
        "CN=a+",     "CN=a,,O=b", "CN=a;O=b", "CN=a\\",  "CN=a\\4",    "CN=a\\q",      "CN=\"a",
        "CN=\"a\"b", "CN=a\"b",   "CN=<",     "CN=\\FF", "CN=#zz",     "CN=#0C05416C", "CN=#020101",
        "CN=a\\00b", "/",         "/x/CN=a",  "/CN",     "/CN=a\\x00", "1.2.x=a"})
    EXPECT_CODE(SubjectName::parse(text), subject_name_malformed);
  EXPECT_CODE(SubjectName::parse("CN=" + std::string(kMaxSubjectOctets, 'x')),
              subject_name_malformed);
  std::string many = "CN=a", slashes;
  for (std::size_t i = 0; i < kMaxNameAttributes; ++i) many += ",CN=a";
  for (std::size_t i = 0; i <= kMaxNameAttributes; ++i) slashes += "/CN=a";
  EXPECT_CODE(SubjectName::parse(many), subject_name_malformed);
  EXPECT_CODE(SubjectName::parse(slashes), subject_name_malformed);
}

TEST(SubjectName, Issuing_RefusesWhatACertificateCannotHold) {
  EXPECT_CODE(Authority::create("C=Netherlands", {}, kYear, test_random()), subject_name_malformed);
  EXPECT_CODE(Authority::create("", {}, kYear, test_random()), subject_name_malformed);
}

}  // namespace
}  // namespace ddssec::pki
