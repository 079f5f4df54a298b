// What a reader holds back for ordered and coherent access.
#include "rtps/dcps/reader_presentation.hpp"

#include <gmock/gmock.h>

#include "rtps/dcps/data_reader_listeners.hpp"
#include "rtps/dcps/received_samples.hpp"
#include "rtps/dcps/requested_liveliness.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

Guid guid_of(std::uint8_t n) { return {GuidPrefix::from(Bytes(12, n)), EntityId{{0, 0, 1, 2}}}; }

struct Presented final : PresentedReader {
  std::vector<std::int64_t> seen;
  KeyHash instance_of(const Change&) const override { return {}; }
  Room room_for(const WantedRoom&, const Guid&) const override { return Room::now; }
  bool present(Change& change) override {
    seen.push_back(change.sequence_number.value);
    return true;
  }
  void note_left(const Guid&) override {}
  void note_lost(std::size_t) override {}
  void give_up(const Guid&, std::size_t, Limit) override {}
};

struct ReaderPresentationTest : ::testing::Test {
  Presented reader;
  ReaderPresentation presentation{reader};
  const MonotonicTime now = std::chrono::seconds(1);

  static Presentation policy(PresentationScope scope, bool coherent, bool ordered) {
    return {.scope = scope, .coherent_access = coherent, .ordered_access = ordered};
  }
  bool put(std::int64_t number, std::int64_t set) {
    Change change;
    change.writer = guid_of(1);
    change.sequence_number = {number};
    change.coherence.set = {set};
    if (set > 0) change.payload = Payload::copy_of(Bytes{1});
    return presentation.on_change(change, now);
  }
};

TEST_F(ReaderPresentationTest, OrderedAlone_HoldsNothingBack) {
  presentation.start(policy(PresentationScope::topic, false, true), nullptr, false, now);
  EXPECT_FALSE(presentation.holds_back());
  presentation.add_writer(guid_of(1), {}, guid_of(1).prefix);
  presentation.release(now);
  presentation.stop(now);
  EXPECT_EQ(presentation.next_tick(), kNever);
}

TEST_F(ReaderPresentationTest, Coherent_SetComesWhenItIsWhole) {
  presentation.start(policy(PresentationScope::topic, true, false), nullptr, false, now);
  ASSERT_TRUE(presentation.holds_back());
  presentation.add_writer(guid_of(1), {}, guid_of(1).prefix);
  EXPECT_TRUE(put(1, 1));
  EXPECT_TRUE(put(2, 1));
  EXPECT_THAT(reader.seen, IsEmpty());
  EXPECT_TRUE(put(3, 0));
  EXPECT_THAT(reader.seen, ElementsAre(1, 2));
}

TEST_F(ReaderPresentationTest, StartedBetweenBeginAndEndAccess_WaitsForItsEnd) {
  presentation.start(policy(PresentationScope::topic, true, false), nullptr, true, now);
  presentation.add_writer(guid_of(1), {}, guid_of(1).prefix);
  EXPECT_TRUE(put(1, 1));
  EXPECT_TRUE(put(2, 0));
  EXPECT_THAT(reader.seen, IsEmpty());
  presentation.pause(false, now);
  presentation.release(now);
  EXPECT_THAT(reader.seen, ElementsAre(1));
}

TEST_F(ReaderPresentationTest, GroupScope_UsesTheSubscribersPresenter) {
  Presenter of_group(Presenter::PresentedAccess{.is_by_group = true, .is_coherent = true});
  presentation.start(policy(PresentationScope::group, true, false), &of_group, false, now);
  EXPECT_TRUE(presentation.holds_back());
  presentation.pause(true, now);  // the presenter of the subscriber is not paused
  presentation.add_writer(guid_of(1), {}, guid_of(1).prefix);
  EXPECT_TRUE(put(1, 1));
  EXPECT_GT(of_group.octets(), 0u);
  presentation.stop(now);
  EXPECT_EQ(of_group.octets(), 0u);
}

}  // namespace
}  // namespace ddssec::rtps
