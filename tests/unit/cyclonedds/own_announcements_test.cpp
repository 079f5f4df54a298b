// Announcements of local participants that the plugin sends itself.
#include "plugins/cyclonedds/own_announcements.hpp"

#include <gmock/gmock.h>

#include "wire/data.hpp"
#include "wire/entity_ids.hpp"
#include "wire/header.hpp"
#include "wire/message_reader.hpp"
#include "wire/parameter_list.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::cyclonedds {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;
using testing::SizeIs;

constexpr GuidPrefix kOwn{{1, 0x10, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}};
constexpr GuidPrefix kOther{{1, 0x10, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9}};
constexpr Guid kPeer{kOther, kEntityIdParticipant};
constexpr spi::IdentityHandle kLocal{1};
const std::vector<spi::UdpAddress> kTo(1);

struct Content {
  GuidPrefix prefix = kOwn;
  bool has_token = true;
  bool has_sentinel = true;
};

// As Cyclone DDS gives it to a handshake.
Bytes participant_data(const Content& content = {}) {
  Bytes octets;
  const auto add = [&](pid::Id id, BytesView value) {
    const auto size = value.size();
    for (const auto octet :
         {id >> 8, id & 0xff, static_cast<int>(size >> 8), static_cast<int>(size & 0xff)})
      octets.push_back(static_cast<std::uint8_t>(octet));
    octets.insert(octets.end(), value.begin(), value.end());
  };
  add(pid::kParticipantGuid, Guid{content.prefix, kEntityIdParticipant}.octets());
  if (content.has_token) add(pid::kIdentityToken, Bytes(8, 7));
  if (content.has_sentinel) add(pid::kSentinel, {});
  return octets;
}

TEST(OwnAnnouncements, Announcement_IsForAllAndHasTheHostsData) {
  for (const bool has_sentinel : {true, false}) {
    const auto octets = write_announcement(kOwn, participant_data({.has_sentinel = has_sentinel}));
    ASSERT_TRUE(octets);
    EXPECT_EQ(rtps::read_header(*octets)->prefix, kOwn);
    auto message = rtps::MessageReader::open(*octets).value();
    const auto submessage = message.next().value();
    ASSERT_TRUE(submessage);
    const auto data = rtps::read_data(*submessage).value();
    EXPECT_EQ(data.writer, rtps::kSpdpWriter);
    EXPECT_EQ(data.sequence_number, rtps::SequenceNumber{1});
    EXPECT_EQ(data.kind, rtps::PayloadKind::data);
    EXPECT_EQ(to_bytes(data.payload.first(4)), (Bytes{0, 2, 0, 0}));
    EXPECT_EQ(to_bytes(data.payload.subspan(4)), participant_data());
    EXPECT_FALSE(message.next().value()) << "no INFO_DST: the peer's host answers";
  }
}

TEST(OwnAnnouncements, DataOfAnotherOrWithoutAToken_IsNotAnnounced) {
  EXPECT_FALSE(write_announcement(kOther, participant_data()));
  EXPECT_FALSE(write_announcement(kOwn, participant_data({.has_token = false})))
      << "the participant would seem to have no security";
  auto cut = participant_data();
  for (; !cut.empty(); cut.pop_back()) {
    const auto told = write_announcement(kOwn, cut);
    EXPECT_EQ(told.has_value(), cut.size() == participant_data().size() ||
                                    cut.size() == participant_data().size() - 4)
        << cut.size();
  }
  EXPECT_FALSE(write_announcement(kOwn, {}));
}

struct Waiting : testing::Test {
  Waiting() { all.note_data(kLocal, kOwn, participant_data()); }
  OwnAnnouncements all;
};

TEST_F(Waiting, AnAnnouncementAfterAReset_IsSentOnceAndLater) {
  all.note_reset(kLocal, kPeer, kTo, 1s);
  all.note_reset(kLocal, kPeer, kTo, 1500ms);
  EXPECT_THAT(all.take_due(1s), IsEmpty());
  const auto due = all.take_due(1s + OwnAnnouncements::kAfterReset);
  ASSERT_THAT(due, SizeIs(1));
  EXPECT_EQ(due[0].peer, kPeer);
  EXPECT_EQ(due[0].message, write_announcement(kOwn, participant_data()));
  EXPECT_THAT(all.take_due(1h), IsEmpty());
}

TEST_F(Waiting, AParticipantThatEndsOrIsNotKnown_IsNotAnnounced) {
  all.note_reset({2}, kPeer, kTo, 1s);
  EXPECT_THAT(all.take_due(1h), IsEmpty());
  all.note_reset(kLocal, kPeer, kTo, 1s);
  all.remove_local(kLocal);
  EXPECT_THAT(all.take_due(1h), IsEmpty());
}

TEST_F(Waiting, LargeDataAndManyPeers_AreBounded) {
  auto large = participant_data();
  large.resize(OwnAnnouncements::kMaxOctets + 4);
  all.note_data(kLocal, kOwn, large);
  Guid peer = kPeer;
  for (std::size_t i = 0; i < OwnAnnouncements::kMaxWaiting + 10; ++i) {
    peer.prefix.octets[10] = static_cast<std::uint8_t>(i >> 8);
    peer.prefix.octets[11] = static_cast<std::uint8_t>(i);
    all.note_reset(kLocal, peer, kTo, 1s);
  }
  const auto due = all.take_due(1h);
  EXPECT_THAT(due, SizeIs(OwnAnnouncements::kMaxWaiting));
  EXPECT_LT(due[0].message.size(), 200u) << "the former, smaller data";
}

}  // namespace
}  // namespace ddssec::cyclonedds
