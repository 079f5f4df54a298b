// Writers for which a keeper had no room are considered again, and take only a fair share of the
// places.
#include "rtps/keeper/refused_writers.hpp"

#include <atomic>
#include <new>
#include <unistd.h>

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

GuidPrefix identity(std::uint8_t number) {
  GuidPrefix out{};
  out.octets.fill(number);
  return out;
}
Guid writer(std::uint8_t owner, std::uint8_t number, std::uint8_t kind = 2) {
  return {identity(owner), EntityId::from(Bytes{0, number, kind, 2})};
}

template <class F>
bool eventually(F&& done) {
  for (int i = 0; i < 1000 && !done(); ++i) ::usleep(10'000);
  return done();
}

TEST(RefusedWritersTest, AWriter_IsConsideredUntilThereIsRoom) {
  std::atomic<int> calls = 0;
  RefusedWriters refused(
      [&](const Guid& which) {
        EXPECT_EQ(which, writer(1, 7));
        return ++calls == 3;
      },
      1ms);
  EXPECT_TRUE(refused.add(writer(1, 7), identity(1)));
  EXPECT_TRUE(eventually([&] { return refused.size() == 0; }));
  EXPECT_EQ(calls, 3);
  ::usleep(20'000);
  EXPECT_EQ(calls, 3) << "it no longer waits";
}

TEST(RefusedWritersTest, AWriter_ThatWaits_IsNotAddedAgain) {
  RefusedWriters refused([](const Guid&) { return false; }, 1h);
  EXPECT_TRUE(refused.add(writer(1, 1), identity(1)));
  EXPECT_FALSE(refused.add(writer(1, 1), identity(1)));
  EXPECT_EQ(refused.size(), 1u);
}

TEST(RefusedWritersTest, OneIdentity_LeavesPlacesForAnother) {
  RefusedWriters refused([](const Guid&) { return false; }, 1h);
  for (int i = 0; i < 2000; ++i)
    refused.add(writer(1, static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(i >> 8)),
                identity(1));
  EXPECT_EQ(refused.size(), RefusedWriters::kMax / 2);
  EXPECT_TRUE(refused.add(writer(2, 1), identity(2)));
  EXPECT_EQ(refused.size(), RefusedWriters::kMax / 2 + 1);
}

TEST(RefusedWritersTest, AnException_DoesNotEndTheThread) {
  std::atomic<int> calls = 0;
  RefusedWriters refused(
      [&](const Guid&) -> bool {
        if (++calls == 1) throw std::bad_alloc();
        return true;
      },
      1ms);
  refused.add(writer(1, 1), identity(1));
  EXPECT_TRUE(eventually([&] { return refused.size() == 0; }));
  EXPECT_EQ(calls, 2);
}

}  // namespace
}  // namespace ddssec::rtps
