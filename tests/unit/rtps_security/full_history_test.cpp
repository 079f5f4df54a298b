// A reliable KEEP_ALL writer with a reader that acknowledges and one that does not.
#include "tests/unit/rtps_security/secured_dcps.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST(DataWriter, AFullHistory_NamesTheReaderThatHoldsItUp) {
  ManualClock clock{pki::kNow};
  const auto rules = everything(ProtectionKind::encrypt);
  Secured alice("CN=alice,O=Example", rules, clock), bob("CN=bob,O=Example", rules, clock),
      carol("CN=carol,O=Example", rules, clock);
  auto offered = default_writer_qos();
  offered.history.kind = HistoryKind::keep_all;
  offered.resource_limits.max_samples = 4;
  offered.reliability.max_blocking_time = Duration::from(20ms);
  auto requested = default_reader_qos();
  requested.reliability.kind = ReliabilityKind::reliable;
  requested.history.kind = HistoryKind::keep_all;
  auto& writer = alice.writer(offered);
  auto &good = bob.reader(requested), &bad = carol.reader(requested);
  bool is_carol_there = true;
  const auto run = [&](int rounds) {
    for (int i = 0; i < rounds; ++i) {
      clock.advance(10ms);
      for (auto* one : {&alice, &bob, &carol})
        if (one != &carol || is_carol_there) one->participant->poll(0ms);
    }
  };
  for (int i = 0; i < 1000 && writer.matched_subscriptions().size() < 2; ++i) run(1);
  ASSERT_EQ(writer.matched_subscriptions().size(), 2u) << alice.events.text();
  ASSERT_TRUE(writer.write({1, 1}));
  run(20);
  is_carol_there = false;
  Status status;
  int written = 1;
  while ((status = writer.write({1, ++written}))) {
    run(5);
    ASSERT_LT(written, 10);
  }
  ASSERT_EQ(code_of(status), Code::rtps_history_full);
  const auto& details = status.error().details();
  EXPECT_THAT(details.found, ::testing::HasSubstr(bad.guid().to_string()));
  EXPECT_THAT(details.found,
              ::testing::HasSubstr("of CN=carol,O=Example has acknowledged up to 1"));
  EXPECT_EQ(details.expected, "an acknowledgment up to sample 2");
  int taken = 0;
  while (good.take_next_sample()) ++taken;
  EXPECT_EQ(taken, written - 1) << "the other reader gets all that was written";
}

}  // namespace
}  // namespace ddssec::rtps
