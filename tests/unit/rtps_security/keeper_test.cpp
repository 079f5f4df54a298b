// A durability service in a domain with access control: who may not write a topic says nothing of
// how it is kept.
#include "rtps/keeper/keeper.hpp"

#include "tests/unit/rtps_security/lax_access_control.hpp"
#include "tests/unit/rtps_security/secured_dcps.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

std::unique_ptr<spi::AccessControl> lax(std::unique_ptr<spi::AccessControl> real) {
  return std::make_unique<LaxAccessControl>(std::move(real));
}

Qos durable(DurabilityKind kind, OwnershipKind ownership = OwnershipKind::shared) {
  auto qos = default_writer_qos();
  qos.durability = kind;
  qos.history.depth = qos.durability_service.history.depth = 10;
  qos.ownership = ownership;
  return qos;
}

struct SecuredKeeper : ::testing::Test {
  ManualClock clock{pki::kNow};
  const Rules rules = everything(ProtectionKind::encrypt);
  SecuredProcess process{clock};
  std::unique_ptr<Keeper> keeper =
      Keeper::create(process.options("CN=keeper,O=Example", rules), {}, process.environment)
          .value();
  Secured alice{"CN=alice,O=Example", rules, clock};
  /// May use another topic only, and does not keep to it.
  std::optional<Secured> mallory{std::in_place,
                                 "CN=mallory,O=Example",
                                 rules,
                                 clock,
                                 "",
                                 std::vector<std::string>{"Other"},
                                 lax};

  template <class F>
  bool eventually(const F& done, int steps = 600) {
    for (int i = 0; i < steps && !done(); ++i) {
      clock.advance(10ms);
      for (int n = 0; n < 4; ++n) {
        keeper->poll(0ms);
        alice.participant->poll(0ms);
        if (mallory) mallory->participant->poll(0ms);
      }
    }
    return done();
  }
  void run(int steps) {
    eventually([] { return false; }, steps);
  }
  bool heard_mallory() {
    return eventually([&] { return process.events.has(Code::announced_writer_not_allowed); });
  }
  std::vector<std::int32_t> late_joiner(std::size_t count) {
    auto qos = default_reader_qos();
    qos.durability = DurabilityKind::transient;
    qos.reliability.kind = ReliabilityKind::reliable;
    qos.history.kind = HistoryKind::keep_all;
    auto& reader = alice.reader(qos);
    std::vector<std::int32_t> out;
    eventually([&] {
      while (const auto sample = reader.take_next_sample()) out.push_back(sample->data.value);
      return out.size() >= count;
    });
    return out;
  }
};

TEST_F(SecuredKeeper, AWriterThatIsNotAllowedSaysNothingOfHowATopicIsKept) {
  mallory->writer(durable(DurabilityKind::transient, OwnershipKind::exclusive));
  ASSERT_TRUE(heard_mallory()) << process.events.text();
  run(50);
  EXPECT_EQ(keeper->topics(), 0u);
  auto* publisher = *alice.participant->create_publisher();
  auto& writer =
      **publisher->create_datawriter<Sensor>(*alice.topic, durable(DurabilityKind::transient));
  ASSERT_TRUE(eventually([&] { return keeper->topics() == 1; })) << process.events.text();
  ASSERT_TRUE(eventually([&] { return !writer.matched_subscriptions().empty(); }));
  run(50);
  for (std::int32_t value = 1; value <= 3; ++value) ASSERT_TRUE(writer.write({value, value}));
  run(50);
  ASSERT_TRUE(publisher->delete_contained_entities());
  EXPECT_EQ(late_joiner(3), (std::vector<std::int32_t>{1, 2, 3})) << process.events.text();
}

// Any participant could fill a keeper with announcements, and leave.
TEST_F(SecuredKeeper, TopicsOfWritersThatAreNotAllowedTakeNoPlace) {
  auto* publisher = *mallory->participant->create_publisher();
  for (int i = 0; i < 40; ++i) {
    auto* topic = *mallory->participant->create_topic<Sensor>("Junk" + std::to_string(i));
    ASSERT_TRUE(publisher->create_datawriter<Sensor>(*topic, durable(DurabilityKind::transient)));
  }
  ASSERT_TRUE(heard_mallory());
  run(100);
  EXPECT_EQ(keeper->topics(), 0u);
  mallory.reset();
  run(50);
  EXPECT_EQ(keeper->topics(), 0u);
}

// From then on nothing of any topic was kept, also after it had left.
TEST_F(SecuredKeeper, OneIdentityDoesNotFillTheStore) {
  keeper.reset();
  keeper = Keeper::create(process.options("CN=keeper,O=Example", rules),
                          {.store_octets = std::size_t{256} << 10}, process.environment)
               .value();
  mallory.emplace("CN=mallory,O=Example", rules, clock);  // may write the topic
  auto qos = durable(DurabilityKind::transient);
  const auto write = [&](Secured& who, std::int32_t first, std::int32_t count) {
    auto& writer = who.writer(qos);
    ASSERT_TRUE(eventually([&] { return !writer.matched_subscriptions().empty(); }));
    for (std::int32_t i = first; i < first + count; ++i) {
      ASSERT_TRUE(writer.write({i, i}));
      if (i % 100 == 0) run(2);
    }
    ASSERT_TRUE(eventually([&] { return writer.wait_for_acknowledgments(0ms).has_value(); }));
    ASSERT_TRUE(eventually([&] { return keeper->unstored() == 0; }));
  };
  write(*mallory, 0, 3000);
  EXPECT_GT(keeper->left_out(), 1000u);
  EXPECT_TRUE(process.events.has(Code::rtps_store_failed));
  const auto before = keeper->left_out();
  write(alice, 1'000'000, 20);
  EXPECT_EQ(keeper->left_out(), before) << process.events.text();
  ASSERT_TRUE(keeper->flush(5s));
  run(5);
  EXPECT_EQ(keeper->served(), 3020 - before) << "what is not stored was held in memory";
}

}  // namespace
}  // namespace ddssec::rtps
