// When a file that cannot be used is reported, and with which words.
#include "base/renewal_refusals.hpp"

#include <gtest/gtest.h>

namespace ddssec {
namespace {

constexpr Sha256Digest kOne{1}, kOther{2};

TEST(RenewalRefusals, FileThatIsWrongOnce_IsNotReported) {
  RenewalRefusals refusals;
  EXPECT_FALSE(refusals.is_due(Code::malformed, kOne)) << "it may be in the middle of a write";
  refusals.clear();
  EXPECT_FALSE(refusals.is_due(Code::malformed, kOne)) << "it was good in between";
}

TEST(RenewalRefusals, FileThatStaysWrong_IsReportedOnce) {
  RenewalRefusals refusals;
  refusals.is_due(Code::malformed, kOne);
  EXPECT_TRUE(refusals.is_due(Code::malformed, kOne));
  EXPECT_FALSE(refusals.is_due(Code::malformed, kOne));
}

TEST(RenewalRefusals, OtherContentOrOtherReason_IsReportedAgain) {
  RenewalRefusals refusals;
  refusals.is_due(Code::malformed, kOne);
  EXPECT_TRUE(refusals.is_due(Code::malformed, kOne));
  EXPECT_TRUE(refusals.is_due(Code::malformed, kOther));
  EXPECT_TRUE(refusals.is_due(Code::truncated, kOther));
}

TEST(RenewalRefusals, LastReport_StandsUntilTheFileIsGood) {
  RenewalRefusals refusals;
  EXPECT_FALSE(refusals.refused());
  EXPECT_EQ(refusals.note(Error(Code::malformed)).code(), Code::malformed);
  ASSERT_TRUE(refusals.refused());
  EXPECT_EQ(refusals.refused()->code(), Code::malformed);
  refusals.clear();
  EXPECT_FALSE(refusals.refused());
}

TEST(RenewalRefused, SaysTheReasonWhatWasNotedAndWhatStays) {
  const Error why(Code::malformed, {.document = "a property",
                                    .field = "notAfter",
                                    .found = "1",
                                    .note = "noted",
                                    .hint = "of the reason"});
  const auto told =
      renewal_refused(Code::identity_renewal_refused, why, "/etc/cert.pem", "the former stays");
  EXPECT_EQ(told.code(), Code::identity_renewal_refused);
  EXPECT_EQ(told.details().document, "/etc/cert.pem");
  EXPECT_EQ(told.details().field, "notAfter");
  EXPECT_EQ(told.details().found, "1");
  EXPECT_EQ(told.details().note,
            std::string(info(Code::malformed).summary) + "; noted; the former stays");
  EXPECT_EQ(told.hint(), info(Code::identity_renewal_refused).hint);
}

TEST(RenewalRefused, ReasonOfTheSameCode_KeepsItsHintAndIsNotRepeated) {
  const Error why(Code::identity_renewal_refused, {.hint = "do this"});
  const auto told =
      renewal_refused(Code::identity_renewal_refused, why, "/etc/cert.pem", "it stays");
  EXPECT_EQ(told.details().note, "it stays");
  EXPECT_EQ(told.hint(), "do this");
}

}  // namespace
}  // namespace ddssec
