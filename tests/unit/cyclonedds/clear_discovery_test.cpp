#include "plugins/cyclonedds/clear_discovery.hpp"

#include <gmock/gmock.h>

#include "base/writer.hpp"
#include "rtps/discovery/endpoint_data.hpp"
#include "wire/entity_ids.hpp"
#include "wire/header.hpp"
#include "wire/info_destination.hpp"
#include "wire/message_reader.hpp"

namespace ddssec::cyclonedds {
namespace {

using namespace std::chrono_literals;
using testing::IsEmpty;
using testing::SizeIs;

constexpr GuidPrefix kOwn{{1, 0x10, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}};
constexpr GuidPrefix kPeer{{1, 0x10, 9, 9, 9, 9, 9, 9, 9, 9, 9, 9}};
constexpr Guid kPeerGuid{kPeer, kEntityIdParticipant};
/// The last two sequence numbers on the wire, little endian; our own readers refuse them.
constexpr std::array<std::uint8_t, 8> kLast{0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 0xff};
constexpr std::array<std::uint8_t, 8> kBeforeLast{0xff, 0xff, 0xff, 0x7f, 0xfe, 0xff, 0xff, 0xff};

bool begins_as_publications(BytesView octets) {
  return octets.size() >= 8 &&
         std::ranges::equal(octets.first(4), rtps::kPublicationsReader.view()) &&
         std::ranges::equal(octets.subspan(4, 4), rtps::kPublicationsWriter.view());
}

TEST(EndOfClearDiscovery, RemovesTheWritersOfClearAnnouncements) {
  const auto octets = write_end_of_clear_discovery(kPeer, kOwn, TypeLookup::stays);
  EXPECT_EQ(rtps::read_header(octets)->prefix, kPeer);
  auto message = rtps::MessageReader::open(octets).value();
  EXPECT_EQ(rtps::read_info_destination(*message.next().value())->prefix, kOwn);
  const auto heartbeat = message.next().value().value();
  EXPECT_EQ(heartbeat.id, rtps::SubmessageId::heartbeat);
  EXPECT_TRUE(begins_as_publications(heartbeat.body));
  EXPECT_TRUE(std::ranges::equal(heartbeat.body.subspan(8, 8), kBeforeLast));
  EXPECT_TRUE(std::ranges::equal(heartbeat.body.subspan(16, 8), kLast));
  EXPECT_TRUE(heartbeat.has(0x02)) << "final: the peer must not be asked for what it never wrote";
  // The writer that says so goes last.
  for (const auto& [number, writer] : {std::pair(kBeforeLast, rtps::kSubscriptionsWriter),
                                       std::pair(kLast, rtps::kPublicationsWriter)}) {
    const auto data = message.next().value().value();
    EXPECT_EQ(data.id, rtps::SubmessageId::data);
    EXPECT_TRUE(begins_as_publications(data.body.subspan(4)));
    EXPECT_TRUE(std::ranges::equal(data.body.subspan(12, 8), number));
    EXPECT_EQ(rtps::read_endpoint_key(data.body.last(28)).value(), (Guid{kPeer, writer}));
  }
  EXPECT_FALSE(message.next().value());
}

/// Of the endpoints that a message disposes, in its order; the numbers must be without a gap.
std::vector<EntityId> disposed(const Bytes& octets) {
  std::vector<EntityId> out;
  auto message = rtps::MessageReader::open(octets).value();
  std::uint8_t number = 0;
  while (const auto submessage = message.next().value()) {
    if (submessage->id == rtps::SubmessageId::heartbeat) number = submessage->body[12];
    if (submessage->id != rtps::SubmessageId::data) continue;
    EXPECT_EQ(submessage->body[16], number++);
    const auto gone = rtps::read_endpoint_key(submessage->body.last(28)).value();
    EXPECT_EQ(gone.prefix, kPeer);
    out.push_back(gone.entity);
  }
  EXPECT_EQ(number, 0) << "the last of all numbers ends with 0xff";
  return out;
}

TEST(EndOfClearDiscovery, RemovesTheWritersOfTypeLookupToo) {
  constexpr EntityId kRequests{{0x00, 0x03, 0x00, 0xc3}}, kReplies{{0x00, 0x03, 0x01, 0xc3}};
  EXPECT_THAT(disposed(write_end_of_clear_discovery(kPeer, kOwn, TypeLookup::ends)),
              testing::ElementsAre(kRequests, kReplies, rtps::kSubscriptionsWriter,
                                   rtps::kPublicationsWriter));
}

void write_locator(Writer& list, std::int32_t kind, std::uint32_t port, std::uint8_t first) {
  list.write(std::uint16_t{0x0032});
  list.write(std::uint16_t{24});
  list.write(kind);
  list.write(port);
  list.write_bytes(Bytes(12));
  list.write_bytes(Bytes{first, 0, 0, 7});
}

TEST(DiscoveryAddresses, AreTheUnicastOnesOverUdp) {
  Writer list(Endian::big, 256);
  write_locator(list, 1, 7410, 10);
  write_locator(list, 1, 7400, 239);  // multicast
  write_locator(list, 16, 7410, 10);  // another transport
  write_locator(list, 1, 70000, 10);  // no port
  write_locator(list, 1, 7412, 127);
  list.write(std::uint16_t{1});
  list.write(std::uint16_t{0});
  const auto found = discovery_addresses(list.take());
  ASSERT_THAT(found, SizeIs(2));
  EXPECT_EQ(found[0].port, 7410);
  EXPECT_EQ(found[0].address[12], 10);
  EXPECT_EQ(found[1].port, 7412);
  EXPECT_THAT(discovery_addresses(as_bytes("no list")), IsEmpty());
}

struct ClearDiscoveryTest : testing::Test {
  ClearDiscoveryTest() { discovery.hears_at(local, {{.port = 7410}}); }

  ManualClock clock{WallTime{}};
  ClearDiscovery discovery{clock};
  const spi::IdentityHandle local{1};
};

TEST_F(ClearDiscoveryTest, IsEndedAtOnceAndSomeTimesMore) {
  EXPECT_EQ(discovery.next(), std::nullopt);
  discovery.established(local, kOwn, kPeerGuid, TypeLookup::ends);
  EXPECT_EQ(discovery.next(), 0ns);
  const auto due = discovery.due();
  ASSERT_THAT(due, SizeIs(1));
  EXPECT_EQ(due[0].message, write_end_of_clear_discovery(kPeer, kOwn, TypeLookup::ends));
  EXPECT_EQ(due[0].to.at(0).port, 7410);
  EXPECT_THAT(discovery.due(), IsEmpty());
  std::size_t said = 1;
  while (const auto left = discovery.next()) {
    clock.advance(*left);
    said += discovery.due().size();
    ASSERT_LE(said, ClearDiscovery::kTimes.size());
  }
  EXPECT_EQ(said, ClearDiscovery::kTimes.size());
}

TEST_F(ClearDiscoveryTest, AThreadThatComesLateSaysItOnce) {
  discovery.established(local, kOwn, kPeerGuid, TypeLookup::stays);
  clock.advance(1s);
  EXPECT_THAT(discovery.due(), SizeIs(1));
  EXPECT_EQ(discovery.next(), 1s);
}

TEST_F(ClearDiscoveryTest, OfOneThatIsGoneIsForgotten) {
  discovery.established(local, kOwn, kPeerGuid, TypeLookup::stays);
  discovery.lost(kPeerGuid);
  EXPECT_EQ(discovery.next(), std::nullopt);
  discovery.established(local, kOwn, kPeerGuid, TypeLookup::stays);
  discovery.remove_local(local);
  EXPECT_THAT(discovery.due(), IsEmpty());
}

}  // namespace
}  // namespace ddssec::cyclonedds
