#include "plugins/cyclonedds/reader_ends.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "plugins/cyclonedds/disposal.hpp"
#include "wire/data.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr GuidPrefix kOwn{{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};

// Waits until another thread has made `is_so` true.
template <class F>
bool eventually(F&& is_so) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!is_so() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return is_so();
}

Guid reader(std::uint8_t number) { return {kOwn, {{0, 0, number, 7}}}; }

// The entities of the host, shared with the thread that looks.
struct World {
  std::mutex mutex;
  bool has_participant = true;
  bool refuses = false;
  std::set<Guid> alive;
  std::vector<Guid> carried;
  int looks = 0;
};

class FakeHost final : public HostEntities {
 public:
  explicit FakeHost(std::shared_ptr<World> world) : world_(std::move(world)) {}
  std::vector<Participant> participants() const override {
    const std::lock_guard lock(world_->mutex);
    ++world_->looks;
    if (!world_->has_participant) return {};
    return {{.handle = 1, .guid = {kOwn, kEntityIdParticipant}, .entities = world_->alive}};
  }
  bool carry_end(const Participant& participant, const Guid& ended) const override {
    const std::lock_guard lock(world_->mutex);
    EXPECT_EQ(participant.handle, 1);
    if (world_->refuses) return false;
    world_->carried.push_back(ended);
    return true;
  }

 private:
  std::shared_ptr<World> world_;
};

struct ReaderEndsTest : ::testing::Test {
  void announce(const Guid& guid) {
    Bytes list(64), octets(128);
    rtps::SpanWriter parameters(list);
    parameters.write_bytes(std::array<std::uint8_t, 4>{0, 3, 0, 0});
    {
      const rtps::ParameterScope key(parameters, pid::kEndpointGuid);
      parameters.write_bytes(guid.octets());
    }
    rtps::write_sentinel(parameters);
    rtps::SpanWriter out(octets);
    write(out, rtps::Data{.reader = rtps::kSubscriptionsSecureReader,
                          .writer = rtps::kSubscriptionsSecureWriter,
                          .kind = rtps::PayloadKind::data,
                          .payload = parameters.view()});
    OwnReaders::Room room;
    ends.readers().said(1, out.view(), room);
  }
  std::vector<Guid> carried() {
    const std::lock_guard lock(world->mutex);
    return world->carried;
  }

  std::shared_ptr<World> world = std::make_shared<World>();
  FakeHost host{world};
  ReaderEnds ends{[this] { return std::make_unique<FakeHost>(world); }};
};

TEST_F(ReaderEndsTest, EndedReader_IsSaidOnceAfterTwoLooks) {
  announce(reader(1));
  announce(reader(2));
  world->alive = {reader(1)};
  EXPECT_TRUE(ends.poll(host));
  EXPECT_TRUE(carried().empty());
  EXPECT_FALSE(ends.poll(host));
  EXPECT_EQ(carried(), std::vector{reader(2)});
  EXPECT_FALSE(ends.poll(host));
  EXPECT_EQ(carried().size(), 1u);
}

TEST_F(ReaderEndsTest, ReaderThatIsThereAgain_IsNotSaid) {
  announce(reader(1));
  EXPECT_TRUE(ends.poll(host));
  world->alive = {reader(1)};
  EXPECT_FALSE(ends.poll(host));
  world->alive.clear();
  EXPECT_TRUE(ends.poll(host)) << "counts anew";
  EXPECT_TRUE(carried().empty());
}

TEST_F(ReaderEndsTest, HostThatRefuses_IsTriedAgain) {
  announce(reader(1));
  world->refuses = true;
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(ends.poll(host));
  world->refuses = false;
  EXPECT_FALSE(ends.poll(host));
  EXPECT_EQ(carried(), std::vector{reader(1)});
}

TEST_F(ReaderEndsTest, GoneParticipant_IsNotSaid) {
  announce(reader(1));
  announce(reader(2));
  world->has_participant = false;
  EXPECT_TRUE(ends.poll(host));
  EXPECT_FALSE(ends.poll(host));
  EXPECT_TRUE(ends.readers().announced().empty());
  EXPECT_TRUE(carried().empty());
}

TEST_F(ReaderEndsTest, Hint_LeadsToALook) {
  announce(reader(1));
  announce(reader(2));
  world->alive = {reader(2)};
  ends.poll_soon();
  EXPECT_TRUE(eventually([&] { return carried() == std::vector{reader(1)}; }));
  ends.stop();
}

// The host announces a reader that ended earlier to each participant that joins later.
TEST_F(ReaderEndsTest, ReadersAnnouncedLater_AreFoundToo) {
  ends.poll_soon();
  announce(reader(1));
  EXPECT_TRUE(eventually([&] { return !carried().empty(); }));
  const auto looks = [&] {
    const std::lock_guard lock(world->mutex);
    return world->looks;
  };
  const auto before = looks();
  std::this_thread::sleep_for(ReaderEnds::kLater + ReaderEnds::kLater / 2);
  EXPECT_EQ(looks(), before) << "the host is left alone while nothing is new";
}

TEST_F(ReaderEndsTest, HostWithoutAFunction_IsNotAsked) {
  std::atomic<int> searches = 0;
  ReaderEnds without([&] {
    ++searches;
    return nullptr;
  });
  without.poll_soon();
  EXPECT_TRUE(eventually([&] { return searches > 0; }));
  announce(reader(1));
  without.poll_soon();
  without.stop();
  EXPECT_TRUE(carried().empty());
}

}  // namespace
}  // namespace ddssec::cyclonedds
