// Files of a folder that someone else has sent: no text takes the doctor minutes, or gigabytes.
#include <ctime>
#include <string>

#include <gtest/gtest.h>

#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/effective_security.hpp"
#include "governance/doctor/lenient_text.hpp"
#include "governance/doctor/named_files.hpp"

namespace ddssec::governance::doctor {
namespace {

std::string repeated(std::string_view part, std::size_t octets) {
  std::string out;
  while (out.size() < octets) out += part;
  return out;
}

// Returns the processor time of `work` in seconds.
template <class Work>
double seconds_of(Work work) {
  const auto begin = std::clock();
  work();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

constexpr double kMaxSeconds = 2;
constexpr std::size_t kOctets = 1'000'000;

// A stranger can sign a document. Each `<a` once made a copy of the rest of the text.
TEST(HostileText, TagsThatDoNotEnd_AreReadInLinearTime) {
  for (const auto* part : {"<", "<a", "<a ", "<a b", "<a b=\"<", "<!DOCTYPE>", "<![CDATA[", "<?"}) {
    const auto text = repeated(part, 100'000);
    EXPECT_LT(seconds_of([&] { (void)lenient_text(as_bytes(std::string_view(text))); }),
              kMaxSeconds)
        << part;
  }
}

// Each comment is blanked. The blanks before it were once searched again for each of them.
TEST(HostileText, CommentsWithDashes_AreReadInLinearTime) {
  for (const auto* part : {"<!--x--y-->", "<!--", "<!---->", "<?x?>", "<![CDATA[]]>"}) {
    const auto text = "<a>" + repeated(part, kOctets);
    EXPECT_LT(seconds_of([&] { (void)lenient_text(as_bytes(std::string_view(text))); }),
              kMaxSeconds)
        << part;
  }
}

TEST(HostileText, LongNames_AreCutInFindings) {
  const std::string name(kOctets / 2, 'n');
  EXPECT_LT(seconds_of([&] {
              const auto text = "<CycloneDDS><" + name + "><b/>" + repeated("x<b/>", kOctets / 2);
              const auto read = effective_security(text, 0, ConfigurationPlace::file);
              EXPECT_FALSE(read.problems.empty());
              for (const auto& problem : read.problems) EXPECT_LT(problem.text.size(), 300u);
            }),
            kMaxSeconds);
}

TEST(HostileText, RepeatedElements_AreReadInLinearTime) {
  const auto text = "<CycloneDDS><Domain><Security><Authentication>" +
                    repeated("<IdentityCA/>", kOctets / 2) + repeated("<CRL/>", kOctets / 2);
  EXPECT_LT(seconds_of([&] { effective_security(text, 0, ConfigurationPlace::file); }),
            kMaxSeconds);
}

// One value belongs to all names before it, and is copied for each.
TEST(HostileText, LongValues_AreCut) {
  const auto text =
      repeated("<name>dds.sec.x.identity_ca</name>", 3'400) + "<value>" + std::string(kOctets, 'v');
  const auto named = named_anywhere_by_fastdds(text);
  EXPECT_EQ(named.size(), 100u);
  for (const auto& one : named) EXPECT_LE(one.value.size(), std::size_t{64} * 1024);
}

TEST(HostileText, TagsInAttributes_AreReadInLinearTime) {
  std::string text = "<a";
  for (int i = 0; i < 12'000; ++i) text += " xmlns:a" + std::to_string(i) + "=\"<\"";
  EXPECT_LT(seconds_of([&] { (void)lenient_text(as_bytes(std::string_view(text))); }), kMaxSeconds);
}

TEST(HostileText, NamesWithoutValues_AreReadInLinearTime) {
  for (const auto* part : {"<name>", "<name></name>", "<name>dds.sec.identity_ca</name>"}) {
    const auto text = repeated(part, kOctets);
    EXPECT_LT(seconds_of([&] { EXPECT_TRUE(named_anywhere_by_fastdds(text).empty()); }),
              kMaxSeconds)
        << part;
  }
}

TEST(HostileText, ElementsThatAreNotClosed_AreReadInLinearTime) {
  EXPECT_LT(seconds_of([] {
              const auto text = repeated("<discovery>", kOctets);
              EXPECT_TRUE(values_within(text, "discovery", "tag").empty());
            }),
            kMaxSeconds);
  EXPECT_LT(seconds_of([] {
              const auto text = "<CycloneDDS>" + repeated("<Domain Id=\"any\">", kOctets);
              effective_security(text, 0, ConfigurationPlace::file);
            }),
            kMaxSeconds);
}

TEST(HostileText, FilesAndFindings_AreLimitedInNumber) {
  const auto broken = effective_security("<", 0, ConfigurationPlace::file);
  EXPECT_LT(seconds_of([&] {
              const auto text = repeated("<IdentityCA>", kOctets);
              EXPECT_EQ(named_by_cyclonedds(text, broken, 0).size(), 10u);
            }),
            kMaxSeconds);
  EXPECT_EQ(named_anywhere_by_fastdds(
                repeated("<name>dds.sec.identity_ca</name><value>a</value>", kOctets))
                .size(),
            100u);
  const auto read =
      effective_security("<CycloneDDS>" + repeated("<a/>", kOctets), 0, ConfigurationPlace::file);
  EXPECT_EQ(read.problems.size(), 100u);
}

// The next value belongs to a name, also where several names come before it.
TEST(NamedFiles, ValueOfAName_IsTheNextOne) {
  const auto named = named_anywhere_by_fastdds(
      "<name>dds.sec.x.identity_ca</name><name>dds.sec.x.private_key</name><value>a</value>"
      "<value>b</value><name>dds.sec.x.governance</name><value>c</value><name>dds.sec.x.crl");
  ASSERT_EQ(named.size(), 3u);
  EXPECT_EQ(named[0].value, "a");
  EXPECT_EQ(named[1].value, "a");
  EXPECT_EQ(named[2].value, "c");
}

}  // namespace
}  // namespace ddssec::governance::doctor
