#include "rtps/security/second_protections.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps_security/phases_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Pair;

constexpr auto kSign = ProtectionKind::sign, kEncrypt = ProtectionKind::encrypt;

// A reader with two protections, and a pair that has keys under both.
class SecondProtectionsTest : public ::testing::Test {
 protected:
  SecondProtectionsTest() { of.add_endpoint(kSign, kEncrypt); }

  SecondProtections& second() { return of.phases.endpoints(); }
  PairKeys& second_keys() { return second().find(of.reader, kNext)->pairs.at(of.writer); }
  bool has_second_keys() { return second().second_keys_of(of.reader, of.writer) != nullptr; }

  Phases of{kSign, kEncrypt};
  const ProtectionId kFormer = protection_id(attributes_with(kSign));
  const ProtectionId kNext = protection_id(attributes_with(kEncrypt));

 private:
  static spi::EndpointSecurityAttributes attributes_with(ProtectionKind submessage) {
    spi::EndpointSecurityAttributes out;
    out.submessage = submessage;
    return out;
  }
};

TEST_F(SecondProtectionsTest, Swapped_TheSecondProtectionIsTheFirst) {
  EXPECT_EQ(second().first_protection_of(of.reader), kFormer);
  EXPECT_TRUE(second().knows(of.reader, kNext));
  second().swap();
  EXPECT_EQ(second().first_protection_of(of.reader), kNext);
  EXPECT_TRUE(second().knows(of.reader, kFormer));
  EXPECT_EQ(second().attributes(of.reader)->submessage, kSign);
}

TEST_F(SecondProtectionsTest, Removed_OnlyTheFirstProtectionIsKnown) {
  second().remove(of.reader);
  EXPECT_EQ(second().attributes(of.reader), nullptr);
  EXPECT_TRUE(second().knows(of.reader, kFormer));
  EXPECT_FALSE(second().knows(of.reader, kNext));
  EXPECT_FALSE(has_second_keys());
}

TEST_F(SecondProtectionsTest, PairWithKeysUnderOneProtection_IsIncompleteIfItMayHaveBoth) {
  EXPECT_THAT(second().incomplete_pairs(of.peer), IsEmpty());
  second().find(of.reader, kNext)->pairs.clear();
  EXPECT_THAT(second().incomplete_pairs(of.peer), ElementsAre(Pair(of.reader, of.writer)));
  EXPECT_THAT(second().incomplete_pairs(Node::candidate(8)), IsEmpty()) << "of another peer";
  second().set_permitted(of.reader, of.writer, false);
  EXPECT_THAT(second().incomplete_pairs(of.peer), IsEmpty());
}

TEST_F(SecondProtectionsTest, SuspendedPairThatReturns_HasItsSecondKeysAgain) {
  second_keys().is_suspended = true;
  EXPECT_FALSE(second().resume(of.reader, of.writer, false)) << "the keys are not doubtful";
  ASSERT_TRUE(has_second_keys());
  EXPECT_FALSE(second_keys().is_suspended);
  EXPECT_TRUE(second_keys().is_unsent) << "our keys are sent again";
}

TEST_F(SecondProtectionsTest, SuspendedPairThatReturnsAsAnotherKind_LosesItsSecondKeys) {
  second_keys().is_suspended = true;
  EXPECT_FALSE(second().resume(of.reader, of.writer, true));
  EXPECT_FALSE(has_second_keys());
}

TEST_F(SecondProtectionsTest, SuspendedPairThatReturnsWithoutThePermission_LosesItsSecondKeys) {
  second_keys().is_suspended = true;
  second().set_permitted(of.reader, of.writer, false);
  EXPECT_FALSE(second().resume(of.reader, of.writer, false));
  EXPECT_FALSE(has_second_keys());
}

TEST_F(SecondProtectionsTest, EndpointAnnouncedWithTheSecondOnly_IsKnownUntilItsPairEnds) {
  EXPECT_FALSE(second().any_announced_with_second(of.peer));
  second().note_announced(of.reader, of.writer, true);
  EXPECT_TRUE(second().any_announced_with_second(of.peer));
  EXPECT_FALSE(second().any_announced_with_second(Node::candidate(8)));
  second().unregister_pair(of.reader, of.writer);
  EXPECT_FALSE(second().any_announced_with_second(of.peer));
}

}  // namespace
}  // namespace ddssec::rtps
