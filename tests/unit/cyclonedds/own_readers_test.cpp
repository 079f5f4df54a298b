#include "plugins/cyclonedds/own_readers.hpp"

#include <malloc.h>
#include <string>

#include <gtest/gtest.h>

#include "plugins/cyclonedds/disposal.hpp"
#include "wire/data.hpp"
#include "wire/data_frag.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr GuidPrefix kOwn{{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
constexpr Guid kReader{kOwn, {{0, 0, 1, 7}}}, kOther{kOwn, {{0, 0, 2, 7}}};
constexpr Guid kCarrier{kOwn, {{0, 0, 9, 4}}};

struct Told {
  Guid reader = kReader;
  std::string topic = "Square";
  BytesView user_data = {};
  EntityId writer = rtps::kSubscriptionsSecureWriter;
  Endian endian = Endian::little;
};

// Returns the parameter list of an announcement.
Bytes list_of(const Told& told) {
  Bytes octets(512 + told.user_data.size());
  rtps::SpanWriter out(octets, told.endian);
  out.write_bytes(std::array<std::uint8_t, 4>{
      0, static_cast<std::uint8_t>(told.endian == Endian::little ? 3 : 2), 0, 0});
  {
    const rtps::ParameterScope name(out, 0x0005);
    out.write(static_cast<std::uint32_t>(told.topic.size() + 1));
    out.write_bytes(as_bytes(told.topic));
    out.write(std::uint8_t{0});
  }
  if (!told.user_data.empty()) {
    const rtps::ParameterScope data(out, 0x002c);
    out.write(static_cast<std::uint32_t>(told.user_data.size()));
    out.write_bytes(told.user_data);
  }
  {
    const rtps::ParameterScope guid(out, pid::kEndpointGuid);
    out.write_bytes(told.reader.octets());
  }
  rtps::write_sentinel(out);
  octets.resize(out.size());
  return octets;
}

Bytes announcement(const Told& told) {
  Bytes octets(640);
  rtps::SpanWriter out(octets, told.endian);
  const auto payload = list_of(told);
  write(out, rtps::Data{.reader = rtps::kSubscriptionsSecureReader,
                        .writer = told.writer,
                        .sequence_number = rtps::SequenceNumber{7},
                        .kind = rtps::PayloadKind::data,
                        .payload = payload});
  octets.resize(out.size());
  return octets;
}

Bytes carrier_of(const Guid& ended) {
  const auto octets = ended.octets();
  return announcement(
      {.reader = kCarrier, .topic = std::string(kCarrierTopic), .user_data = octets});
}

struct Sender : ::testing::Test {
  Bytes said(BytesView submessage) {
    OwnReaders::Room room;
    const auto octets = own.said(1, submessage, room);
    return {octets.begin(), octets.end()};
  }
  OwnReaders own;
};
using OwnReadersTest = Sender;

TEST_F(OwnReadersTest, AnnouncedReaders_AreKnown) {
  for (const auto endian : {Endian::little, Endian::big}) {
    OwnReaders fresh;
    OwnReaders::Room room;
    const auto octets = announcement({.endian = endian});
    EXPECT_EQ(fresh.said(1, octets, room).data(), octets.data()) << "sent as it is";
    EXPECT_EQ(fresh.said(1, octets, room).data(), octets.data());
    EXPECT_EQ(fresh.announced(), std::vector{kReader});
    EXPECT_EQ(fresh.count(), 1u) << "once";
  }
}

TEST_F(OwnReadersTest, AnnouncementsOfOtherWriters_AreIgnored) {
  for (const auto& writer :
       {rtps::kSubscriptionsWriter, rtps::kPublicationsSecureWriter, EntityId{{0, 0, 1, 2}}})
    said(announcement({.writer = writer}));
  EXPECT_TRUE(own.announced().empty());
}

TEST_F(OwnReadersTest, FirstFragment_MakesThemKnown) {
  Bytes octets(2048);
  rtps::SpanWriter out(octets);
  const auto whole = list_of({});
  const auto part = BytesView(whole).first(whole.size() - 4);
  write(out, rtps::DataFrag{.reader = rtps::kSubscriptionsSecureReader,
                            .writer = rtps::kSubscriptionsSecureWriter,
                            .fragment_size = static_cast<std::uint16_t>(part.size()),
                            .sample_size = 3000,
                            .payload = part});
  octets.resize(out.size());
  EXPECT_EQ(said(octets), octets);
  EXPECT_EQ(own.announced(), std::vector{kReader});
}

// Returns a fragment of 1,000 octets.
Bytes fragment_of(BytesView whole, std::uint32_t number) {
  const std::size_t from = (number - 1) * std::size_t{1000};
  Bytes octets(2048);
  rtps::SpanWriter out(octets);
  write(out, rtps::DataFrag{
                 .reader = rtps::kSubscriptionsSecureReader,
                 .writer = rtps::kSubscriptionsSecureWriter,
                 .first = {number},
                 .fragment_size = 1000,
                 .sample_size = static_cast<std::uint32_t>(whole.size()),
                 .payload = whole.subspan(from, std::min<std::size_t>(1000, whole.size() - from))});
  octets.resize(out.size());
  return octets;
}

// The announcements of readers with much USER_DATA, or of large types, have several fragments.
// These readers must not stay matched after their end.
TEST_F(OwnReadersTest, AreKnownByLaterFragments_OfEachSender) {
  const Bytes data(2990, 5);
  const auto one = list_of({.user_data = data}),
             two = list_of({.reader = kOther, .user_data = data});
  ASSERT_EQ(one.size(), two.size());
  OwnReaders::Room room;
  for (const std::uint32_t number : {1U, 2U, 3U}) {
    own.said(1, fragment_of(one, number), room);
    own.said(2, fragment_of(two, number), room);
  }
  EXPECT_TRUE(own.announced().empty());
  own.said(1, fragment_of(one, 4), room);
  EXPECT_EQ(own.announced(), std::vector{kReader});
  own.said(2, fragment_of(two, 3), room);  // is repeated
  EXPECT_EQ(own.announced(), std::vector{kReader});
  for (const std::uint32_t number : {1U, 2U, 3U, 4U}) own.said(2, fragment_of(two, number), room);
  EXPECT_EQ(own.announced(), (std::vector{kReader, kOther}));
}

TEST_F(OwnReadersTest, CarriersAnnouncement_BecomesTheEndOfTheReader) {
  said(announcement({}));
  const auto sent = said(carrier_of(kReader));
  const rtps::SubmessageView view{static_cast<rtps::SubmessageId>(sent[0]), sent[1],
                                  BytesView(sent).subspan(rtps::kSubmessageHeaderSize), sent};
  const auto data = rtps::read_data(view).value();
  EXPECT_EQ(data.reader, rtps::kSubscriptionsSecureReader);
  EXPECT_EQ(data.writer, rtps::kSubscriptionsSecureWriter);
  EXPECT_EQ(data.sequence_number.value, 7) << "that of the carrier";
  EXPECT_EQ(data.kind, rtps::PayloadKind::key);
  EXPECT_TRUE(data.inline_qos.status.disposed);
  EXPECT_TRUE(data.inline_qos.status.unregistered);
  EXPECT_EQ(data.inline_qos.key_hash, kReader.octets());
  EXPECT_EQ(to_hex(data.payload).find(to_hex(kReader.octets())), 16u);
  EXPECT_EQ(said(carrier_of(kReader)), sent) << "as often as the host repeats it";
  EXPECT_EQ(own.announced(), std::vector{kReader}) << "the carrier is none of them";
}

// An application can make such a reader, but it cannot end other readers with it.
TEST_F(OwnReadersTest, ReadersOfOtherParticipants_DoNotEnd) {
  auto strange = kReader;
  strange.prefix.octets[0] ^= 1;
  const auto octets = carrier_of(strange);
  EXPECT_EQ(said(octets), octets);
  const auto unnamed = announcement({.reader = kCarrier, .topic = std::string(kCarrierTopic)});
  EXPECT_EQ(said(unnamed), unnamed);
}

TEST_F(OwnReadersTest, EndedReaders_AreNotAnnouncedAgain) {
  said(announcement({}));
  said(announcement({.reader = kOther}));
  own.note_ended(kReader);
  said(announcement({}));  // the host announces it to each participant that joins later
  EXPECT_EQ(own.announced(), std::vector{kOther});
}

Guid reader_with_key(std::uint32_t key) {
  return {kOwn,
          {{static_cast<std::uint8_t>(key >> 16), static_cast<std::uint8_t>(key >> 8),
            static_cast<std::uint8_t>(key), 7}}};
}

// The host keeps the announcements of deleted readers, and repeats them to each participant that
// joins later.
TEST_F(OwnReadersTest, OneHundredThousandDeleted_TakeABitEachAndStayEnded) {
  constexpr std::uint32_t kDeleted = 100'000;
  const auto before = ::mallinfo2().uordblks;
  for (std::uint32_t key = 1; key <= kDeleted; ++key) {
    said(announcement({.reader = reader_with_key(key)}));
    own.note_ended(reader_with_key(key));
  }
  EXPECT_LT(::mallinfo2().uordblks, before + kDeleted);
  for (std::uint32_t key = 1; key <= kDeleted; ++key)
    said(announcement({.reader = reader_with_key(key)}));
  EXPECT_TRUE(own.announced().empty());
  EXPECT_EQ(own.count(), kDeleted);
  said(announcement({.reader = reader_with_key(kDeleted + 1)}));
  EXPECT_EQ(own.announced(), std::vector{reader_with_key(kDeleted + 1)});
}

TEST_F(OwnReadersTest, LargestKeyDeleted_OthersStayAnnounced) {
  const auto last = reader_with_key(0xffffff);
  said(announcement({}));
  said(announcement({.reader = last}));
  own.note_ended(last);
  said(announcement({.reader = last}));
  EXPECT_EQ(own.announced(), std::vector{kReader});
}

TEST_F(OwnReadersTest, ForgottenParticipant_ForgetsThem) {
  said(announcement({}));
  own.note_ended(kReader);
  said(announcement({.reader = kOther}));
  own.forget(kOwn);
  EXPECT_TRUE(own.announced().empty());
  said(announcement({}));
  EXPECT_EQ(own.announced(), std::vector{kReader});
}

// A later version of the host may announce the end of a reader itself.
TEST_F(OwnReadersTest, EndSaidByTheHost_EndsThemToo) {
  said(announcement({}));
  Bytes octets(256);
  rtps::SpanWriter out(octets);
  write(out, Disposal{.reader = rtps::kSubscriptionsSecureReader,
                      .writer = rtps::kSubscriptionsSecureWriter,
                      .number = rtps::SequenceNumber{8},
                      .key = pid::kEndpointGuid,
                      .gone = kReader});
  octets.resize(out.size());
  EXPECT_EQ(said(octets), octets);
  EXPECT_TRUE(own.announced().empty());
}

TEST_F(OwnReadersTest, AnnouncementsThatEndEarly_AreSentAsTheyAre) {
  const auto whole = carrier_of(kReader);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto cut = BytesView(whole).first(size);
    OwnReaders::Room room;
    const auto sent = own.said(1, cut, room);
    EXPECT_TRUE(sent.data() == cut.data() || sent.size() <= room.size()) << size;
  }
}

}  // namespace
}  // namespace ddssec::cyclonedds
