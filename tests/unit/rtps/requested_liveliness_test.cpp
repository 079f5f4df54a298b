// Leases of writers, as a reader sees them.
#include "rtps/dcps/requested_liveliness.hpp"

#include <gmock/gmock.h>

#include "rtps/dcps/reader_presentation.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/dcps_parts.hpp"

namespace ddssec::rtps::dcps_parts {
namespace {

using namespace testing;
using std::chrono::milliseconds;
using ::testing::ElementsAre;

Guid guid_of(std::uint8_t n) { return {GuidPrefix::from(Bytes(12, n)), EntityId{{0, 0, 1, 2}}}; }

struct Asserted final : EndpointListener {
  std::vector<Guid> alive;
  void on_matched(const EndpointData&) override {}
  void on_unmatched(const Guid&) override {}
  void on_incompatible_qos(const Guid&, const QosMismatch&) override {}
  void on_inconsistent_topic(const EndpointData&) override {}
  void on_alive(const Guid& writer) override { alive.push_back(writer); }
};

struct RequestedLivelinessTest : StatusChangesTest {
  TimerQueue timers;
  Asserted reader;
  std::vector<Guid> lost;
  RequestedLiveliness liveliness{timers, reader, entity.changes_,
                                 [this](std::span<const Guid> writers, MonotonicTime) {
                                   lost.assign(writers.begin(), writers.end());
                                 }};
};

TEST_F(RequestedLivelinessTest, LeasesThatEnd_AreReportedTogether) {
  const auto lease = Duration::from(milliseconds(100));
  liveliness.add_writer(guid_of(1), lease, milliseconds(0));
  liveliness.add_writer(guid_of(2), lease, milliseconds(0));
  liveliness.add_writer(guid_of(3), lease, milliseconds(0));
  liveliness.on_alive(guid_of(3), milliseconds(90));
  EXPECT_EQ(liveliness.read_status().alive_count_change, 3);
  timers.run(milliseconds(100));
  EXPECT_THAT(lost, ElementsAre(guid_of(1), guid_of(2)));
  EXPECT_TRUE(entity.changes_.contains(StatusKind::liveliness_changed));
  const auto status = liveliness.read_status();
  EXPECT_EQ(status.alive_count, 1);
  EXPECT_EQ(status.not_alive_count_change, 2);
  EXPECT_FALSE(entity.changes_.contains(StatusKind::liveliness_changed));
  liveliness.stop();
  EXPECT_EQ(timers.next(), kNever);
}

TEST_F(RequestedLivelinessTest, WriterThatIsNotAlive_WaitsForItsSignal) {
  const auto signal = std::make_shared<LivelinessSignal>(milliseconds(0));
  liveliness.add_writer(guid_of(1), Duration::from(milliseconds(100)), milliseconds(0));
  liveliness.on_signal(guid_of(1), signal);
  timers.run(milliseconds(100));
  EXPECT_THAT(lost, ElementsAre(guid_of(1)));
  signal->assert_at(milliseconds(150));
  EXPECT_THAT(reader.alive, ElementsAre(guid_of(1)));
}

}  // namespace
}  // namespace ddssec::rtps::dcps_parts
