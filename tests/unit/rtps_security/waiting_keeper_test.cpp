// Samples that wait because the keeper has no room for them.
#include "rtps/keeper/instance_owners.hpp"
#include "rtps/keeper/request_pace.hpp"
#include "tests/unit/rtps_security/secured_keeper.hpp"

namespace ddssec::rtps {

struct Chunk {
  std::int32_t id = 0;
  std::vector<std::uint8_t> octets = {};
};
template <>
struct TypeTraits<Chunk> {
  static constexpr std::string_view type_name = "Chunk";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("id", key(s.id)), named("octets", s.octets));
  }
};

namespace {

using namespace testing;

TEST(RequestPace, ALargerSample_IsRequestedAgainLater) {
  RequestPace pace;
  EXPECT_TRUE(pace.is_due(0ms));
  pace.note_requested(100, 0ms);
  EXPECT_FALSE(pace.is_due(499ms));
  EXPECT_TRUE(pace.is_due(500ms));
  pace.note_requested(60'000'000, 1s);
  EXPECT_FALSE(pace.is_due(30s));
  EXPECT_TRUE(pace.is_due(31s));
}

// It must not be sent again twice a second.
TEST_F(SmallSecuredKeeper, ALargeSampleThatWaits_IsSeldomSentAgain) {
  auto* topic = *alice.participant->create_topic<Chunk>("Chunks");
  auto* publisher = &alice.participant->create_publisher();
  auto& writer = **publisher->create_datawriter<Chunk>(*topic, qos);
  ASSERT_TRUE(eventually([&] { return !writer.matched_subscriptions().empty(); }));
  ASSERT_TRUE(writer.write({0, std::vector<std::uint8_t>(2 << 20)}));
  ASSERT_TRUE(eventually([&] { return keeper->unstored() > 0; }));
  int requests = 0;
  bool waits = true;
  for (int i = 1; i <= 1000; ++i) {
    if (i % 20 == 0) {
      ASSERT_TRUE(writer.write({1, {}}));
    }
    run(1);
    const bool did = std::exchange(waits, keeper->unstored() > 0);
    requests += did && !waits ? 1 : 0;
  }
  EXPECT_GE(requests, 1) << "its writer may have replaced it";
  EXPECT_LE(requests, 11) << "in 10 s, each of 2 MiB";
  EXPECT_TRUE(eventually([&] { return keeper->unstored() > 0; }));
}

struct ExclusiveSecuredKeeper : SecuredKeeper {
  static constexpr std::int32_t kShare = InstanceOwners::kMaxInstances / 2;
  DataWriter<Sensor>& writer_of(Secured& whose, std::int32_t strength) {
    auto qos = durable(DurabilityKind::transient, OwnershipKind::exclusive);
    qos.history.depth = qos.durability_service.history.depth = 1;
    qos.ownership_strength = strength;
    auto& out = whose.writer(qos);
    EXPECT_TRUE(eventually([&] { return !out.matched_subscriptions().empty(); }));
    run(50);
    return out;
  }
  bool stored_all_of(DataWriter<Sensor>& writer, int steps = 600) {
    return eventually(
        [&] { return keeper->flush(5s) && writer.wait_for_acknowledgments(0ms).has_value(); },
        steps);
  }
  void write(DataWriter<Sensor>& writer, std::int32_t first, std::int32_t count) {
    for (std::int32_t i = first; i < first + count; ++i) {
      ASSERT_TRUE(writer.write({i, 1}));
      if (i % 64 == 0) keeper->poll(0ms);
      if (i % 1024 != 0) continue;
      ASSERT_TRUE(stored_all_of(writer));
    }
  }
};

TEST_F(ExclusiveSecuredKeeper, BeyondAnIdentitysInstances_SamplesWait_AndAreNotAcknowledged) {
  mallory.emplace("CN=mallory,O=Example", rules, clock);  // this one may write the topic
  auto& greedy = writer_of(*mallory, 10);
  write(greedy, 0, kShare);
  ASSERT_TRUE(stored_all_of(greedy));
  EXPECT_EQ(keeper->served(), static_cast<std::uint64_t>(kShare));
  auto& more = writer_of(*mallory, 20);
  ASSERT_TRUE(more.write({1'000'000, 1}));
  EXPECT_FALSE(stored_all_of(more, 100));
  EXPECT_EQ(keeper->served(), static_cast<std::uint64_t>(kShare));
  EXPECT_GT(keeper->unstored(), 0u);
  for (int i = 0; i < 5000 && !process.events.has(Code::rtps_store_failed); ++i) ::usleep(1000);
  EXPECT_TRUE(process.events.has(Code::rtps_store_failed)) << process.events.text();

  auto& other = writer_of(alice, 5);
  for (std::int32_t i = 0; i < 20; ++i) ASSERT_TRUE(other.write({2'000'000 + i, 1}));
  EXPECT_TRUE(stored_all_of(other)) << "there is room for another identity";
  EXPECT_EQ(keeper->served(), static_cast<std::uint64_t>(kShare) + 20);

  mallory.reset();  // its instances have no owner any more
  ASSERT_TRUE(eventually([&] { return keeper->abandoned() == 1; }));
  ASSERT_TRUE(other.write({0, 2}));
  EXPECT_TRUE(stored_all_of(other));
}

}  // namespace
}  // namespace ddssec::rtps
