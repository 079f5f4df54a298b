#include "rtps/keeper/overtaken.hpp"

#include "tests/unit/rtps_durability/store_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct OvertakenTest : ::testing::Test {
  static Guid writer(std::uint8_t number) {
    Guid out;
    out.prefix.octets[0] = number;
    return out;
  }
  /// The writer's sample of an instance, by its time.
  static Change change(std::uint8_t from, std::uint32_t instance, std::int32_t time) {
    auto out = sample(instance, 1 << 20);
    out.key_hash.emplace()[0] = static_cast<std::uint8_t>(instance);
    (*out.key_hash)[1] = static_cast<std::uint8_t>(instance >> 8);
    out.writer = writer(from);
    out.source_time = seconds(time);
    return out;
  }
  static Change end(std::uint8_t from, std::uint32_t instance, std::int32_t time) {
    auto out = change(from, instance, time);
    out.status.disposed = true;
    return out;
  }
  Overtaken overtaken;
};

TEST_F(OvertakenTest, ALaterSampleOfAnother_OvertakesWhatWaits) {
  overtaken.wait(writer(1));
  overtaken.note(change(2, 7, 20));
  EXPECT_TRUE(overtaken.is_overtaken(change(1, 7, 10), false));
  EXPECT_FALSE(overtaken.is_overtaken(change(1, 7, 30), false)) << "it is later";
  EXPECT_FALSE(overtaken.is_overtaken(change(1, 8, 10), false)) << "another instance";
  EXPECT_FALSE(overtaken.is_overtaken(change(1, 7, 10), true)) << "nothing has ended";
  overtaken.note(end(2, 7, 25));
  EXPECT_TRUE(overtaken.is_overtaken(change(1, 7, 10), true));
}

TEST_F(OvertakenTest, WithoutWaiting_TimestampsDoNotCount) {
  overtaken.note(change(2, 7, 20));
  EXPECT_EQ(overtaken.size(), 0u);
  overtaken.wait(writer(1));
  overtaken.note(change(2, 7, 20));
  EXPECT_FALSE(overtaken.is_overtaken(change(3, 7, 10), false)) << "the writer does not wait";
}

TEST_F(OvertakenTest, ItsOwnSamples_OvertakeNothing) {
  overtaken.wait(writer(1));
  overtaken.note(change(1, 7, 20));
  EXPECT_FALSE(overtaken.is_overtaken(change(1, 7, 10), false));
}

TEST_F(OvertakenTest, WhenNobodyWaits_AllIsForgotten) {
  overtaken.wait(writer(1));
  overtaken.note(change(2, 7, 20));
  overtaken.begin_pass();
  EXPECT_TRUE(overtaken.is_overtaken(change(1, 7, 10), false)) << "it still waited";
  overtaken.wait(writer(1));
  overtaken.end_pass();
  EXPECT_EQ(overtaken.size(), 1u);
  overtaken.begin_pass();
  overtaken.end_pass();
  EXPECT_EQ(overtaken.size(), 0u);
  overtaken.wait(writer(1));
  overtaken.note(change(2, 7, 20));
  overtaken.forget(writer(1));
  EXPECT_EQ(overtaken.size(), 0u);
}

TEST_F(OvertakenTest, ManyInstances_AreBounded) {
  overtaken.wait(writer(1));
  for (std::uint32_t i = 0; i < 2 * Overtaken::kMost; ++i) overtaken.note(change(2, i, 20));
  EXPECT_EQ(overtaken.size(), Overtaken::kMost);
  EXPECT_FALSE(overtaken.is_overtaken(change(1, 0, 10), false)) << "the oldest is forgotten";
}

}  // namespace
}  // namespace ddssec::rtps
