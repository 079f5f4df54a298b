// Questions to our other libraries in the process when these are not loaded.
#include "plugins/cyclonedds/process_questions.hpp"

#include <gtest/gtest.h>

namespace ddssec::cyclonedds {
namespace {

TEST(ProcessQuestions, ProcessWithoutCryptography_KnowsNothingAndHasTheStandardCiphers) {
  EXPECT_FALSE(has_our_cryptography());
  EXPECT_EQ(ciphers_of_process(), spi::kStandardCiphers);
  const auto questions = questions_to_cryptography();
  EXPECT_FALSE(questions.has_keys);
  EXPECT_FALSE(questions.has_keys_for);
  EXPECT_FALSE(questions.is_matched);
  EXPECT_FALSE(questions.last_heard);
}

TEST(ProcessQuestions, ProcessWithoutAccessControl_RenewsNoPermissions) {
  std::uint64_t known = 3;
  EXPECT_EQ(renewed_permissions({1}, known), std::nullopt);
  EXPECT_EQ(known, 3u);
}

TEST(ProcessQuestions, ParticipantOfNoLibrary_HasNoFacts) {
  EXPECT_FALSE(holds(GovernanceFact::cut_off, {}));
}

}  // namespace
}  // namespace ddssec::cyclonedds
