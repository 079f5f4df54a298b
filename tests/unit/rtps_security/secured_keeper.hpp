// A keeper in a domain with access control, and two participants of other subjects.
#pragma once

#include "rtps/keeper/keeper.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/rtps_security/lax_access_control.hpp"
#include "tests/unit/rtps_security/secured_dcps.hpp"

namespace ddssec::rtps::testing {

inline std::unique_ptr<spi::AccessControl> lax(std::unique_ptr<spi::AccessControl> real) {
  return std::make_unique<LaxAccessControl>(std::move(real));
}

inline Qos durable(DurabilityKind kind, OwnershipKind ownership = OwnershipKind::shared) {
  auto qos = default_writer_qos();
  qos.durability = kind;
  qos.history.depth = qos.durability_service.history.depth = 10;
  qos.ownership = ownership;
  return qos;
}

struct SecuredKeeper : ::testing::Test {
  test::TemporaryFolder folder;  ///< for stores
  ManualClock clock{pki::kNow};
  const Rules rules = everything(ProtectionKind::encrypt);
  SecuredProcess process{clock};
  std::unique_ptr<Keeper> keeper =
      Keeper::create(process.options("CN=keeper,O=Example", rules), {}, process.services).value();
  Secured alice{"CN=alice,O=Example", rules, clock};
  /// Mallory may use another topic only, and does not obey this.
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
  /// Lets the keeper store a sample of the topic. Its writer then leaves.
  void store_one(Topic& topic) {
    auto* publisher = &alice.participant->create_publisher();
    auto& writer =
        **publisher->create_datawriter<Sensor>(topic, durable(DurabilityKind::transient));
    ASSERT_TRUE(eventually([&] { return !writer.matched_subscriptions().empty(); }));
    run(50);
    ASSERT_TRUE(writer.write({1, 7}));
    run(50);
    ASSERT_TRUE(keeper->flush(5s));
    ASSERT_TRUE(publisher->delete_contained_entities());
  }
  /// A thread of its own considers refused topics again, once a second.
  bool keeps_one_soon() {
    for (int i = 0; i < 100 && keeper->topics() == 0; ++i) {
      run(30);
      std::this_thread::sleep_for(100ms);
    }
    return keeper->topics() == 1;
  }
};

/// A keeper with a store so small that an identity soon uses up its share.
struct SmallSecuredKeeper : SecuredKeeper {
  Qos qos = durable(DurabilityKind::transient);
  DataWriter<Sensor>* of_alice = nullptr;
  DataWriter<Sensor>* of_mallory = nullptr;

  void SetUp() override {
    keeper.reset();
    keeper = Keeper::create(process.options("CN=keeper,O=Example", rules),
                            {.store_octets = std::size_t{256} << 10}, process.services)
                 .value();
    mallory.emplace("CN=mallory,O=Example", rules, clock);  // this one may write the topic
    of_alice = &alice.writer(qos);
    of_mallory = &mallory->writer(qos);
  }
  /// Writes samples of different instances.
  void write(DataWriter<Sensor>& writer, std::int32_t first, std::int32_t count) {
    ASSERT_TRUE(eventually([&] { return !writer.matched_subscriptions().empty(); }));
    for (std::int32_t i = first; i < first + count; ++i) {
      ASSERT_TRUE(writer.write({i, i}));
      if (i % 100 != 0) continue;
      run(2);
      ASSERT_TRUE(keeper->flush(5s));
    }
  }
  /// True once the keeper has stored all samples. The store has a thread of its own, which does not
  /// follow the test's clock.
  bool stored_all_of(DataWriter<Sensor>& writer) {
    return eventually(
        [&] { return keeper->flush(5s) && writer.wait_for_acknowledgments(0ms).has_value(); });
  }
};

}  // namespace ddssec::rtps::testing
