// Certificate authorities and participants' certificates for tests: with one clock, one validity
// and one source of random numbers.
#pragma once

#include <string_view>
#include <utility>

#include <gtest/gtest.h>

#include "pki/authority.hpp"
#include "tests/support/seeded_random.hpp"

namespace ddssec::test {

/// The time at which tests judge certificates and documents.
inline constexpr WallTime kNow{std::chrono::sys_days(std::chrono::year(2026) / 11 / 21)};
/// A validity that began a day before kNow, and ends a year after it.
inline constexpr pki::Validity kYear{kNow - std::chrono::hours(24), kNow + std::chrono::days(365)};

inline Random& test_random() {
  static SeededRandom random(42);
  return random;
}

inline pki::Authority make_ca(std::string_view subject = "CN=Test CA,O=Example",
                              pki::KeySpec key = {}, pki::Validity validity = kYear) {
  auto ca = pki::Authority::create(subject, key, validity, test_random());
  EXPECT_TRUE(ca) << ca.error().to_sentence();
  return *std::move(ca);
}

inline pki::Credential make_leaf(const pki::Authority& ca,
                                 std::string_view subject = "CN=talker,O=Example",
                                 pki::KeySpec key = {}, pki::Validity validity = kYear) {
  auto leaf = ca.issue(subject, key, validity, test_random());
  EXPECT_TRUE(leaf) << leaf.error().to_sentence();
  return *std::move(leaf);
}

}  // namespace ddssec::test
