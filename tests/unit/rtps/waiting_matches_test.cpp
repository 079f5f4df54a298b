#include "rtps/participant/waiting_matches.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

GuidPrefix identity(std::uint8_t number) {
  GuidPrefix out;
  out.octets[0] = number;
  return out;
}
Guid endpoint(std::uint8_t of, std::size_t number) {
  Guid out{identity(of), {}};
  out.entity.octets[0] = static_cast<std::uint8_t>(number >> 8);
  out.entity.octets[1] = static_cast<std::uint8_t>(number);
  return out;
}
bool anywhere(const GuidPrefix&) { return true; }

TEST(WaitingMatchesTest, LongestWaiting_IsFirst_AndIdentitiesTakeTurns) {
  WaitingMatches waiting;
  for (const std::size_t number : {3, 1, 2}) waiting.add(endpoint(1, number), identity(1), false);
  waiting.add(endpoint(2, 5), identity(2), false);
  EXPECT_EQ(waiting.take(anywhere), endpoint(1, 3));
  EXPECT_EQ(waiting.take(anywhere), endpoint(2, 5));
  EXPECT_EQ(waiting.take(anywhere), endpoint(1, 1));
  EXPECT_EQ(waiting.take(anywhere), endpoint(1, 2));
  EXPECT_TRUE(waiting.empty());
  EXPECT_EQ(waiting.take(anywhere), std::nullopt);
}

TEST(WaitingMatchesTest, IdentityWithoutRoom_KeepsNoOtherWaiting) {
  WaitingMatches waiting;
  waiting.add(endpoint(1, 1), identity(1), true);
  waiting.add(endpoint(2, 1), identity(2), true);
  const auto of_second = [](const GuidPrefix& of) { return of == identity(2); };
  EXPECT_EQ(waiting.take(of_second), endpoint(2, 1));
  EXPECT_EQ(waiting.take(of_second), std::nullopt);
  EXPECT_FALSE(waiting.empty());
}

TEST(WaitingMatchesTest, ProvenOne_IsTakenBeforeThoseThatAnyoneCanHaveAnnounced) {
  WaitingMatches waiting;
  for (std::size_t i = 0; i < WaitingMatches::kMaxOfOne + 9; ++i)
    waiting.add(endpoint(1, i), identity(1), false);
  waiting.add(endpoint(1, 5000), identity(1), true);
  EXPECT_EQ(waiting.take(anywhere), endpoint(1, 5000));
  std::size_t others = 0;
  while (waiting.take(anywhere)) ++others;
  EXPECT_EQ(others, WaitingMatches::kMaxOfOne);
}

TEST(WaitingMatchesTest, OneThatHasEnded_IsNotTaken) {
  WaitingMatches waiting;
  waiting.add(endpoint(1, 1), identity(1), false);
  waiting.add(endpoint(1, 1), identity(1), false);
  waiting.add(endpoint(1, 2), identity(1), true);
  waiting.remove(endpoint(1, 1));
  waiting.remove(endpoint(1, 3));
  EXPECT_EQ(waiting.take(anywhere), endpoint(1, 2));
  EXPECT_TRUE(waiting.empty());
}

}  // namespace
}  // namespace ddssec::rtps
