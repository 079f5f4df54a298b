// Subjects as Fast DDS compares them; measured with Fast DDS 2.9.1 and 3.1.2.
#include "governance/fastdds_subject.hpp"

#include <gtest/gtest.h>

namespace ddssec::governance {
namespace {

constexpr std::string_view kCertificate = "CN=talker,O=Acme,C=DE";

TEST(FastddsSubject, SpacesBesideAComma_DoNotCount) {
  for (const char* const grant :
       {"CN=talker,O=Acme,C=DE", "CN=talker, O=Acme, C=DE", " CN=talker ,O=Acme , C=DE "})
    EXPECT_TRUE(fastdds_takes(grant, kCertificate)) << grant;
}

TEST(FastddsSubject, AnyOtherDifference_IsAnotherSubject) {
  for (const char* const grant :
       {"", "CN=talker", "CN=talker,O=Acme", "C=DE,O=Acme,CN=talker", "CN=Talker,O=Acme,C=DE",
        "CN = talker,O=Acme,C=DE", "CN=talker,O=Acme,C=DE,L=x", "\tCN=talker,O=Acme,C=DE",
        "CN=talker,O=Ac me,C=DE"})
    EXPECT_FALSE(fastdds_takes(grant, kCertificate)) << grant;
}

TEST(FastddsSubject, EmptyPart_EndsTheName) {
  EXPECT_TRUE(fastdds_takes("CN=talker,O=Acme,C=DE,,L=x", kCertificate));
  EXPECT_TRUE(fastdds_takes(",CN=talker", ",O=Acme")) << "both are empty";
  EXPECT_FALSE(fastdds_takes("CN=talker,,O=Acme,C=DE", kCertificate));
  EXPECT_FALSE(fastdds_takes("CN=talker,O=Acme,C=DE, ,L=x", kCertificate)) << "a space is a part";
}

TEST(NewerFastddsSubject, OrderAndSpaces_DoNotCount) {
  for (const char* const grant :
       {"CN=talker,O=Acme,C=DE", "C=DE,O=Acme,CN=talker", "C = DE , O= Acme,CN =talker"})
    EXPECT_TRUE(fastdds3_applies_grant(grant, kCertificate)) << grant;
  for (const char* const grant : {"CN=talker,O=Acme", "CN=talker,O=Acme,C=DE,L=x",
                                  "CN=Talker,O=Acme,C=DE", "CN=talker,O=Acme,C=D E"})
    EXPECT_FALSE(fastdds3_applies_grant(grant, kCertificate)) << grant;
}

TEST(NewerFastddsSubject, PartWithoutAnEqualsSign_EndsTheName) {
  EXPECT_TRUE(fastdds3_applies_grant("CN=talker,O=Acme,C=DE,x,L=y", kCertificate));
  EXPECT_FALSE(fastdds3_applies_grant("CN=talker,x,O=Acme,C=DE", kCertificate));
}

}  // namespace
}  // namespace ddssec::governance
