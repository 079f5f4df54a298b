#include "base/openssl_flaws.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/expect_code.hpp"

namespace ddssec {
namespace {

using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::StartsWith;

// Returns the flaws of a version, with "?" after each that the number alone does not prove.
std::vector<std::string> of(std::string_view version) {
  std::vector<std::string> out;
  for (const auto& flaw : openssl_flaws(version))
    out.push_back(std::string(flaw.id) + (flaw.is_certain ? "" : "?"));
  return out;
}

TEST(OpensslAdvice, Debian12_LosesAFlawWithEachRelease) {
  EXPECT_THAT(of("3.0.17"), ElementsAre("CVE-2026-22796", "CVE-2026-45447", "delta-crl-as-complete",
                                        "CVE-2026-35189"));
  // Debian's 3.0.18-1~deb12u2 has the fix of 3.0.19, and calls itself 3.0.18.
  EXPECT_THAT(of("3.0.18"), ElementsAre("CVE-2026-22796?", "CVE-2026-45447",
                                        "delta-crl-as-complete", "CVE-2026-35189"));
  EXPECT_THAT(of("3.0.19"),
              ElementsAre("CVE-2026-45447", "delta-crl-as-complete", "CVE-2026-35189"));
  EXPECT_THAT(of("3.0.20"),
              ElementsAre("CVE-2026-45447?", "delta-crl-as-complete", "CVE-2026-35189"));
  EXPECT_THAT(of("3.0.22"), ElementsAre("CVE-2026-35189?"));
  EXPECT_THAT(of("3.0.23"), IsEmpty());
}

TEST(OpensslAdvice, Debian13_LosesAFlawWithEachRelease) {
  EXPECT_THAT(of("3.5.1"), ElementsAre("CVE-2026-22796", "CVE-2026-45447", "delta-crl-as-complete",
                                       "CVE-2026-35189"));
  EXPECT_THAT(of("3.5.4"), ElementsAre("CVE-2026-22796?", "CVE-2026-45447", "delta-crl-as-complete",
                                       "CVE-2026-35189"));
  EXPECT_THAT(of("3.5.7"), ElementsAre("delta-crl-as-complete?", "CVE-2026-35189"));
  EXPECT_THAT(of("3.5.9"), IsEmpty());
}

TEST(OpensslAdvice, SeriesThatEnded_KeepTheirFlaws) {
  const auto flaws = openssl_flaws("3.2.6");
  ASSERT_EQ(flaws.size(), 4u);
  for (const auto& flaw : flaws) {
    EXPECT_TRUE(flaw.is_certain) << flaw.id;
    EXPECT_EQ(flaw.fixed_in, "") << flaw.id;
  }
}

TEST(OpensslAdvice, VersionsThatUbuntuKeeps_ProveNothing) {
  for (const auto* version : {"3.0.2", "3.0.13"}) {
    EXPECT_THAT(of(version), Not(IsEmpty()));
    for (const auto& flaw : openssl_flaws(version)) EXPECT_FALSE(flaw.is_certain) << version;
    EXPECT_TRUE(check_openssl_flaws(version)) << version;
  }
}

TEST(OpensslAdvice, TheTextOfTheLibrary_IsUnderstoodAndNonsenseIsNot) {
  EXPECT_EQ(of("OpenSSL 3.0.19 27 Jan 2026"), of("3.0.19"));
  EXPECT_EQ(of("OpenSSL 3.0.19-dev "), of("3.0.19"));
  for (const auto* text : {"", "OpenSSL", "3", "3.0", "3.0.", "3.0.x", "99999999999.0.1", "3..19"})
    EXPECT_THAT(of(text), IsEmpty()) << text;
  EXPECT_THAT(of("9.9.9"), IsEmpty());
  EXPECT_THAT(of("0.0.0"), IsEmpty());
}

TEST(OpensslAdvice, FlawsOfAMaintainedSeries_HaveASummaryAndAFixedVersion) {
  for (const auto* version : {"3.0.0", "3.0.19", "3.5.1"}) {
    const auto flaws = openssl_flaws(version);
    EXPECT_THAT(flaws, Not(IsEmpty())) << version;
    for (const auto& flaw : flaws) {
      EXPECT_NE(flaw.summary, "") << flaw.id;
      EXPECT_NE(flaw.fixed_in, "") << flaw.id;
      EXPECT_THAT(of(flaw.fixed_in), Each(Not(StartsWith(std::string(flaw.id))))) << flaw.id;
    }
  }
}

TEST(OpensslAdvice, Warning_TellsWhatIsGuardedFromWhatIsNot) {
  const auto guarded = check_openssl_flaws("OpenSSL 3.0.19 27 Jan 2026");
  ASSERT_FALSE(guarded);
  EXPECT_CODE(guarded, openssl_known_unsafe);
  EXPECT_THAT(guarded.error().to_sentence(),
              HasSubstr("(found OpenSSL 3.0.19); ddssec refuses the input that uses them; update"));
  EXPECT_LE(guarded.error().to_sentence().size(), 200u);  // every process with security prints it
  const auto open = check_openssl_flaws("3.0.7");
  ASSERT_FALSE(open);
  EXPECT_CODE(open, openssl_known_unsafe);
  EXPECT_THAT(open.error().to_sentence(),
              HasSubstr("only an update helps against CVE-2023-2650; ddssec refuses the input that "
                        "uses the others; update"));
}

TEST(OpensslAdvice, VersionThatProvesNothing_GetsNoWarning) {
  EXPECT_TRUE(
      // The newest version in Debian 12 has every fix.
      check_openssl_flaws("OpenSSL 3.0.22 25 Aug 2026"));
  EXPECT_TRUE(check_openssl_flaws("3.0.23"));
  EXPECT_TRUE(check_openssl_flaws("no version at all"));
}

}  // namespace
}  // namespace ddssec
