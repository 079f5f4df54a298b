// Whether the plugins start: what the host can do, and the time by which documents are judged.
#include "secured/start_check.hpp"

#include <gtest/gtest.h>

#include "tests/support/expect_code.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::secured {
namespace {

constexpr DomainId kDomain = 5;

rtps::testing::Rules with_key_revision() {
  auto rules = rtps::testing::everything(ProtectionKind::encrypt);
  rules.revises_keys = true;
  return rules;
}

TEST(StartCheck, GovernanceWithKeyRevision_StartsInAnEmbeddedHostOnly) {
  const auto properties = rtps::testing::properties_of("CN=alice,O=Example", with_key_revision());
  EXPECT_TRUE(check_start(properties, embedded_access_control_options(), kDomain, pki::kNow));
  EXPECT_CODE(check_start(properties, {}, kDomain, pki::kNow), governance_not_enforceable);
}

TEST(StartCheck, DocumentsThatHaveEnded_AreRefusedByTheGivenTime) {
  const auto properties = rtps::testing::properties_of("CN=alice,O=Example", with_key_revision());
  EXPECT_CODE(check_start(properties, embedded_access_control_options(), kDomain,
                          pki::kNow + std::chrono::days(36'500)),
              certificate_expired);
}

}  // namespace
}  // namespace ddssec::secured
