#include "plugins/cyclonedds/dispose_announcements.hpp"

#include <gmock/gmock.h>

#include "rtps/discovery/participant_data.hpp"
#include "wire/data.hpp"
#include "wire/entity_ids.hpp"
#include "wire/header.hpp"
#include "wire/info_destination.hpp"
#include "wire/message_reader.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr GuidPrefix kOwn{{1, 0x10, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}};
constexpr GuidPrefix kPeer{{1, 0x10, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9}};

TEST(DisposeAnnouncements, OurLeaving_IsADisposeForThePeerAlone) {
  const auto octets = write_dispose_announcement(kOwn, kPeer);
  EXPECT_EQ(rtps::read_header(octets)->prefix, kOwn);
  auto message = rtps::MessageReader::open(octets).value();
  const auto destination = message.next().value();
  ASSERT_TRUE(destination);
  EXPECT_EQ(rtps::read_info_destination(*destination)->prefix, kPeer);
  const auto submessage = message.next().value();
  ASSERT_TRUE(submessage);
  const auto data = rtps::read_data(*submessage).value();
  EXPECT_EQ(data.writer, rtps::kSpdpWriter);
  EXPECT_EQ(data.reader, rtps::kSpdpReader);
  EXPECT_EQ(data.kind, rtps::PayloadKind::key);
  EXPECT_EQ(data.inline_qos.status, (rtps::StatusInfo{.disposed = true, .unregistered = true}));
  const Guid own{kOwn, kEntityIdParticipant};
  EXPECT_EQ(data.inline_qos.key_hash, own.octets());
  EXPECT_EQ(rtps::read_participant_key(data.payload).value(), own);
  EXPECT_FALSE(message.next().value());
}

TEST(DisposeAnnouncements, LocalParticipants_AreListedUntilRemoved) {
  DisposeAnnouncements dispose_announcements;
  dispose_announcements.add_local({1}, kOwn);
  dispose_announcements.add_local({2}, kPeer);
  dispose_announcements.remove_local({2});
  ASSERT_EQ(dispose_announcements.locals().size(), 1u);
  EXPECT_EQ(dispose_announcements.locals().front().prefix, kOwn);
}

}  // namespace
}  // namespace ddssec::cyclonedds
