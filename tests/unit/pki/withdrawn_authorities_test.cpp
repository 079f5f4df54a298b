#include "pki/withdrawn_authorities.hpp"

#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

TEST(WithdrawnAuthorities, CaThatLeft_DoesNotComeBack) {
  const std::vector first{make_ca("CN=Root").certificate()};
  const std::vector second{make_ca("CN=Root").certificate()};
  const std::vector both{first.front(), second.front()};
  WithdrawnAuthorities withdrawn;
  ASSERT_TRUE(withdrawn.check(first, both));
  withdrawn.note(first, both);
  ASSERT_TRUE(withdrawn.check(both, second));
  withdrawn.note(both, second);
  EXPECT_CODE(withdrawn.check(second, both), ca_put_back);
  EXPECT_CODE(withdrawn.check(second, first), ca_put_back);
  EXPECT_TRUE(withdrawn.check(second, second));
}

TEST(WithdrawnAuthorities, MoreThanAreRemembered_AreRefused) {
  const auto ca = make_ca("CN=Root");
  WithdrawnAuthorities withdrawn;
  std::vector present{ca.certificate()};
  for (std::size_t i = 0; i < WithdrawnAuthorities::kMaxWithdrawn; ++i) {
    const std::vector next{ca.renewed(kYear, test_random()).value()};
    ASSERT_TRUE(withdrawn.check(present, next));
    withdrawn.note(present, next);
    present = next;
  }
  EXPECT_CODE(withdrawn.check(present, {ca.renewed(kYear, test_random()).value()}), ca_put_back);
  EXPECT_TRUE(withdrawn.check(present, present));
}

TEST(WithdrawnAuthorities, Description_IsShort) {
  const auto ca = make_ca("CN=Root");
  EXPECT_EQ(describe({ca.certificate()}).substr(0, 18),
            "CN=Root (SHA-256 " + to_hex(ca.certificate().fingerprint()).substr(0, 1));
  EXPECT_LE(describe(std::vector(100, ca.certificate())).size(), 512u);
}

}  // namespace
}  // namespace ddssec::pki
