#include "rtps/reliability/past_writers.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

GuidPrefix identity(std::uint8_t n) { return GuidPrefix::from(Bytes(12, n)); }
Guid writer(std::uint8_t of, std::uint32_t n) {
  return {identity(of), {{static_cast<std::uint8_t>(n >> 8), static_cast<std::uint8_t>(n), 0, 2}}};
}
PastWriters::Position position(std::int64_t next) { return {{}, {next}, 7}; }

TEST(PastWriters, SecondTake_FindsNothing) {
  PastWriters past;
  past.add(writer(1, 1), identity(1), position(5));
  past.add(writer(1, 1), identity(1), position(6));
  EXPECT_FALSE(past.take(writer(1, 2)));
  const auto taken = past.take(writer(1, 1));
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->next, SequenceNumber{6});
  EXPECT_EQ(taken->last_heartbeat, 7);
  EXPECT_FALSE(past.take(writer(1, 1)));
}

// Otherwise an insider with 1100 writers that come and go could make the recorded samples of others
// new again.
TEST(PastWriters, ManyOfOneIdentity_DoNotDisplaceThoseOfOthers) {
  PastWriters past;
  past.add(writer(1, 1), identity(1), position(5));
  for (std::uint32_t i = 0; i < 3 * PastWriters::kMax; ++i)
    past.add(writer(2, i), identity(2), position(i));
  EXPECT_TRUE(past.take(writer(1, 1)));
  EXPECT_FALSE(past.take(writer(2, 0))) << "its oldest";
  EXPECT_TRUE(past.take(writer(2, 3 * PastWriters::kMax - 1)));
  EXPECT_TRUE(past.take(writer(2, 2 * PastWriters::kMax + 10)));
}

TEST(PastWriters, RevisedWhileAway_ReturnWithTheNewKeys) {
  PastWriters past;
  const Sha256Digest next{1};
  for (const std::uint32_t n : {1u, 2u}) {
    auto at = position(5);
    at.newest_next = {5};
    past.add(writer(1, n), identity(1), at);
  }
  past.add(writer(2, 1), identity(2), position(5));
  past.note_revised(writer(1, 1), [&](const Guid&) { return next; });
  past.distrust_former_keys(identity(1));
  const auto revised = past.take(writer(1, 1)), other = past.take(writer(1, 2));
  EXPECT_EQ(revised->keys, next);
  EXPECT_EQ(revised->newest_next, SequenceNumber{1});
  EXPECT_EQ(other->keys, Sha256Digest{});
  EXPECT_EQ(other->newest_next, SequenceNumber{5});
  EXPECT_TRUE(revised->is_doubted && other->is_doubted);
  EXPECT_FALSE(past.take(writer(2, 1))->is_doubted) << "of another participant";
}

}  // namespace
}  // namespace ddssec::rtps
