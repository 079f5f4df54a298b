// Changes of a writer that expire.
#include "rtps/dcps/writer_lifespan.hpp"

#include <gmock/gmock.h>

#include "rtps/dcps/offered_liveliness.hpp"
#include "rtps/reliability/writer_history.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct WriterLifespanTest : ::testing::Test {
  WriterLifespan lifespan;
  std::vector<std::int64_t> expired_by(MonotonicTime now) {
    std::vector<std::int64_t> out;
    lifespan.expire(now, [&](SequenceNumber change) { out.push_back(change.value); });
    return out;
  }
};

TEST_F(WriterLifespanTest, Infinite_NothingExpires) {
  lifespan.add({1}, kDurationInfinite, milliseconds(0));
  EXPECT_EQ(lifespan.next_tick(), kNever);
  lifespan.add({2}, kNever);
  EXPECT_EQ(lifespan.next_tick(), kNever);
}

TEST_F(WriterLifespanTest, Finite_ChangesExpireOnceInOrder) {
  const auto lifetime = Duration::from(milliseconds(500));
  lifespan.add({1}, milliseconds(100));
  lifespan.add({2}, lifetime, milliseconds(0));
  lifespan.add({3}, lifetime, milliseconds(10));
  EXPECT_EQ(lifespan.next_tick(), milliseconds(100));
  EXPECT_THAT(expired_by(milliseconds(99)), IsEmpty());
  EXPECT_THAT(expired_by(milliseconds(509)), ElementsAre(1, 2));
  EXPECT_THAT(expired_by(milliseconds(510)), ElementsAre(3));
  EXPECT_EQ(lifespan.next_tick(), kNever);
}

TEST_F(WriterLifespanTest, Shortened_LaterChangesExpireBeforeEarlierOnes) {
  lifespan.add({1}, Duration::from(milliseconds(500)), milliseconds(0));
  lifespan.add({2}, Duration::from(milliseconds(10)), milliseconds(0));
  EXPECT_EQ(lifespan.next_tick(), milliseconds(10));
  EXPECT_THAT(expired_by(milliseconds(10)), ElementsAre(2));
  EXPECT_EQ(lifespan.next_tick(), milliseconds(500));
}

// Otherwise a writer of 1 kHz with a lifespan of a day would keep 1.4 GB of numbers.
TEST_F(WriterLifespanTest, ChangesLeftTheHistory_AreForgotten) {
  Qos qos;
  qos.history = {HistoryKind::keep_last, 2};
  WriterHistory history(qos);
  for (int i = 0; i < 10'000; ++i) {
    Change change;
    change.payload = Payload::copy_of(Bytes{1});
    lifespan.add(history.add(std::move(change)), Duration::from(std::chrono::hours(24)),
                 milliseconds(i));
    lifespan.forget_dropped(history);
    ASSERT_LE(lifespan.size(), 100U);
  }
  EXPECT_THAT(expired_by(std::chrono::hours(25)), ::testing::IsSupersetOf({9'999, 10'000}));
}

}  // namespace
}  // namespace ddssec::rtps
