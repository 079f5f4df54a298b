#include "governance/cyclonedds_subject.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance {
namespace {

Permissions with(std::vector<std::string> subjects) {
  Permissions out;
  for (auto& subject : subjects)
    out.grants.push_back(
        {.subject_name = std::move(subject), .line = static_cast<int>(out.grants.size()) + 1});
  return out;
}

// Returns "CERTIFICATE <- GRANT" for each grant that is applied to another subject, with a '!' if a
// grant of its own is skipped for it.
std::vector<std::string> strays(const Permissions& document, const Permissions& other) {
  const Permissions* const both[] = {&document, &other};
  std::vector<std::string> out;
  for (const auto& stray : misapplied_grants(document, both))
    out.push_back(stray.certificate + " <- " + stray.grant->subject_name +
                  (stray.has_own ? "!" : ""));
  return out;
}
std::vector<std::string> strays(const Permissions& document) { return strays(document, document); }
using Strays = std::vector<std::string>;

// Measured with Cyclone DDS 0.10.2: a '/' separates parts of a subject within names, too.
TEST(CycloneddsSubject, AGrantWithMoreThanTheCertificate_IsTaken) {
  EXPECT_TRUE(cyclonedds_applies_grant("CN=/a", "CN=/a"));
  EXPECT_TRUE(cyclonedds_applies_grant("CN=/a/b", "CN=/a"));
  EXPECT_TRUE(cyclonedds_applies_grant("CN=/b/a", "CN=/a/b"));
  EXPECT_TRUE(cyclonedds_applies_grant("X,CN=talker", "CN=talker"));
  EXPECT_TRUE(cyclonedds_applies_grant(",CN=talker,,", "CN=talker"));
  EXPECT_FALSE(cyclonedds_applies_grant("CN=/a", "CN=/a/b"));
  EXPECT_FALSE(cyclonedds_applies_grant("CN=/c/b", "CN=/a/b"));
  EXPECT_FALSE(cyclonedds_applies_grant("CN=q,O=x/z", "CN=q,O=x/y"));
  EXPECT_FALSE(cyclonedds_applies_grant("CN=talker", "CN=talker,O=acme"));
}

// Measured: only the first grant that fits counts.
TEST(CycloneddsSubject, SeveralGrants_AreDecidedByTheirOrder) {
  EXPECT_EQ(strays(with({"CN=a", "CN=a,OU=x"})), Strays());
  EXPECT_EQ(strays(with({"CN=a,OU=x", "CN=a"})), Strays{"CN=a <- CN=a,OU=x!"});
  EXPECT_EQ(strays(with({"CN=/a/OU=b", "CN=/a"})), Strays{"CN=/a <- CN=/a/OU=b!"});
  EXPECT_EQ(strays(with({"CN=/a", "CN=/a/OU=b"})), Strays());
  EXPECT_EQ(strays(with({"CN=a", "CN=b", "CN=a"})), Strays());
}

TEST(CycloneddsSubject, AnotherSpellingOfOneSubject_IsNoStray) {
  EXPECT_EQ(strays(with({"/O=x/CN=a", "CN=a,O=x"})), Strays());
  EXPECT_EQ(strays(with({"CN=a,O=x,OU=y", "/O=x/CN=a"})), Strays{"CN=a,O=x <- CN=a,O=x,OU=y!"});
}

TEST(CycloneddsSubject, SubjectsOfAnotherDocument_AreLookedUp) {
  EXPECT_EQ(strays(with({"CN=a,OU=x"}), with({"CN=a", "CN=b"})), Strays{"CN=a <- CN=a,OU=x"});
}

TEST(CycloneddsSubject, ExpressionsAndBrokenNames_AreLeftOut) {
  auto document = with({"CN=a,OU=x", "CN=a", "no name", ""});
  document.grants[1].subject_is_expression = true;
  EXPECT_EQ(strays(document), Strays());
}

}  // namespace
}  // namespace ddssec::governance
