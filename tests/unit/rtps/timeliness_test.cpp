// How long a fast writer waits for readers that acknowledge late or never.
#include <gmock/gmock.h>

#include "tests/unit/rtps/reliability_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace of_reliability;

constexpr auto kMaxDelay = Timeliness::kMaxDelay;
const Guid kSilent{GuidPrefix::from(Bytes(12, 0xcc)), testing::kReader};

// A writer with many instances (KEEP_LAST 1), one honest reader, and one that acknowledges nothing.
struct TimelinessTest : ::testing::Test {
  Pair pair{default_writer_qos()};
  std::uint32_t written = 0;

  void match_silent() { pair.writer.match({kSilent, true, false, {kHere}}, pair.now); }
  void write(int samples) {
    for (int i = 0; i < samples; ++i, ++written)
      pair.write(Bytes(10'000), KeyHash{static_cast<std::uint8_t>(written % 200)});
  }
  bool is_ahead() { return pair.writer.is_ahead(pair.now); }
  // True if the writer is ahead at some time while it writes samples for that long.
  bool is_ahead_during(MonotonicTime time) {
    bool out = false;
    for (const auto end = pair.now + time; pair.now < end; pair.run(1)) {
      write(1);
      out = is_ahead() || out;
    }
    return out;
  }
};

TEST_F(TimelinessTest, ReaderThatNeverAcknowledges_HoldsUpForABoundedTime) {
  pair.match();
  match_silent();
  pair.run(3);
  write(60);
  EXPECT_TRUE(is_ahead());
  is_ahead_during(kMaxDelay + milliseconds(50));
  EXPECT_FALSE(is_ahead_during(milliseconds(10'000)));
  // They are held for that reader, but no write waits for it.
  EXPECT_GT(pair.writer.history().octets(), 1'000'000u);
}

TEST_F(TimelinessTest, AloneAndNeverAcknowledging_HoldsUpForABoundedTime) {
  match_silent();
  write(60);
  EXPECT_TRUE(is_ahead());
  is_ahead_during(kMaxDelay + milliseconds(50));
  EXPECT_FALSE(is_ahead_during(milliseconds(10'000)));
}

// The reader acknowledges one more sample every 100 ms.
TEST_F(TimelinessTest, ReaderThatAcknowledgesSampleBySample_HoldsUpForABoundedTime) {
  match_silent();
  write(60);
  bool ahead = false;
  for (std::int32_t count = 1; count <= 100; ++count) {
    const AckNack one{testing::kReader, testing::kWriter, SequenceNumberSet({count + 1}), count,
                      true};
    pair.writer.on_acknack(kSilent.prefix, one, pair.now, true, KeyAge::newest);
    ahead = is_ahead_during(milliseconds(100));
    if (count == 1) {
      EXPECT_TRUE(ahead);
    }
  }
  EXPECT_FALSE(ahead);
}

TEST_F(TimelinessTest, HonestReaderBesideASilentOne_StillHoldsUpABurst) {
  pair.match();
  match_silent();
  pair.run(3);
  write(60);
  is_ahead_during(kMaxDelay + milliseconds(50));
  ASSERT_FALSE(is_ahead_during(milliseconds(1'000)));
  write(60);
  EXPECT_TRUE(is_ahead());
  pair.run(20);
  EXPECT_FALSE(is_ahead());
}

TEST_F(TimelinessTest, ReaderThatCatchesUp_HoldsUpAgain) {
  pair.match();
  pair.run(3);
  pair.net.loss_percent = 100;
  write(60);
  is_ahead_during(kMaxDelay + milliseconds(50));
  ASSERT_FALSE(is_ahead());
  pair.net.loss_percent = 0;
  pair.run(300);
  write(1);
  EXPECT_FALSE(is_ahead());
  pair.run(20);
  write(60);
  is_ahead();
  EXPECT_TRUE(is_ahead());
}

TEST(WriterHistoryOctets, OctetsAfterANumber_AreThoseOfTheHeldChanges) {
  WriterHistory history{of_reliability::keep_all()};
  for (std::size_t size = 1; size <= 4; ++size) {
    Change change;
    change.payload = Payload::copy_of(Bytes(size));
    history.add(std::move(change));
  }
  EXPECT_EQ(history.octets_after({0}, 100), 10u);
  EXPECT_EQ(history.octets_after({2}, 100), 7u);
  history.discard({3});
  EXPECT_EQ(history.octets_after({2}, 100), 4u);
  EXPECT_EQ(history.octets_after({4}, 100), 0u);
  EXPECT_GT(history.octets_after({0}, 3), 3u);
}

}  // namespace
}  // namespace ddssec::rtps
