// What strangers claim takes bounded memory and no time: floods and forgeries against a whole
// participant, with its memory counted.
#include <gtest/gtest.h>

#include "tests/support/counted_memory.hpp"
#include "tests/unit/rtps/participant_fixture.hpp"

namespace ddssec::rtps {
namespace {

using counted_memory::octets;
using std::chrono::seconds;
using testing::message;
using testing::written;
using testing::socketless::Node;
using testing::socketless::World;

constexpr std::int64_t kMiB = 1 << 20;

Bytes from(const GuidPrefix& source, Bytes message) {
  std::ranges::copy(source.octets, message.begin() + 8);
  return message;
}

/// An announcement of whichever participant, to be changed in place.
class Announcement {
 public:
  Announcement() {
    const auto marked = GuidPrefix::from(Bytes(12, 0xee));
    ParticipantData data;
    data.guid = {marked, kEntityIdParticipant};
    data.metatraffic_unicast = {*Locator::parse("127.0.0.1", 7009)};
    data.builtin_endpoints = builtin_endpoints::kWithoutSecurity;
    std::array<std::uint8_t, 1024> buffer{};
    SpanWriter payload(buffer);
    write_payload(payload, data);
    octets_ =
        from(marked, message({written(Data{
                         kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, payload.view()})}));
    for (auto at = octets_.begin();; at += 12) {
      at = std::search(at, octets_.end(), marked.octets.begin(), marked.octets.end());
      if (at == octets_.end()) break;
      places_.push_back(static_cast<std::size_t>(at - octets_.begin()));
    }
  }
  BytesView of(std::uint32_t number) {
    for (const auto place : places_)
      for (std::size_t i = 0; i < 4; ++i)
        octets_[place + i] = static_cast<std::uint8_t>(number >> (8 * i));
    return octets_;
  }

 private:
  Bytes octets_;
  std::vector<std::size_t> places_;
};

// T60 and CVE-2026-45092: bounded answers as well.
TEST(Bounds, AMillionFakeParticipantsTakeABoundedPlace) {
  Node a(1);
  Announcement announcement;
  const auto before = octets();
  for (std::uint32_t i = 0; i < 1'000'000; ++i)
    a.participant.receive(announcement.of(i), seconds(1));
  EXPECT_EQ(a.participant.remote_participants(), Participant::kMostParticipants);
  EXPECT_EQ(a.participant.counters().refused_discovery, 1'000'000 - Participant::kMostParticipants);
  EXPECT_LT(a.post.sent.size(), 8 * Participant::kMostParticipants);
  a.post.sent = {};
  EXPECT_LT(octets() - before, 8 * kMiB);
}

// g++ 12 does not destroy the members of an aggregate that a return in its middle leaves.
TEST(Bounds, APropertyWhoseValueIsCutOffIsForgotten) {
  Bytes payload = {0, 3, 0, 0, 0x59, 0, 44, 0, 1, 0, 0, 0, 32, 0, 0, 0};
  payload.insert(payload.end(), 31, 'n');
  payload.insert(payload.end(), {0, 0xff, 0, 0, 0, 1, 0, 0, 0});
  ASSERT_FALSE(read_participant_data(payload));
  const auto before = octets();
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(read_participant_data(payload));
  EXPECT_EQ(octets(), before);
}

/// A reader here, and many writers of another participant that matched it.
struct Matched : ::testing::Test {
  static constexpr int kWriters = 16;
  Node a{1}, b{2};
  World world{{&a, &b}};
  std::vector<Guid> writers;
  std::int64_t before = 0;

  void SetUp() override {
    const auto request = [](Qos qos) {
      return Participant::EndpointRequest{"Topic", "Type", std::move(qos), true};
    };
    auto wanted = default_reader_qos();
    wanted.reliability.kind = ReliabilityKind::reliable;
    ASSERT_TRUE(a.participant.create_reader(request(wanted), a.listener, world.now));
    for (int i = 0; i < kWriters; ++i)
      writers.push_back(
          *b.participant.create_writer(request(default_writer_qos()), b.listener, world.now));
    world.run();
    ASSERT_EQ(a.listener.matched, kWriters);
    before = octets();
  }
  template <class S>
  void forge(const S& submessage) {
    a.participant.receive(from(b.participant.prefix(), message({written(submessage)})), world.now);
  }
  void expect_that_samples_come() {
    a.post.sent = b.post.sent = {};
    for (const auto& guid : writers) {
      Change change;
      change.payload = Payload::copy_of(Bytes(64));
      b.participant.writer(guid)->write(std::move(change), world.now);
    }
    world.run(100);
    EXPECT_EQ(a.listener.changes.size(), writers.size());
  }
};

#if defined(__SANITIZE_ADDRESS__)
constexpr std::int64_t kIncomplete = 10;  // each is marked octet by octet
#else
constexpr std::int64_t kIncomplete = 1000;
#endif

TEST_F(Matched, FragmentsThatNeverCompleteTakeABoundedPlace) {
  const Bytes fragment(1024);
  for (std::int64_t number = 1; number <= kIncomplete; ++number)
    for (const auto& guid : writers)
      forge(DataFrag{{},
                     guid.entity,
                     {number},
                     {1},
                     1,
                     1024,
                     StatefulReader::kLargestSample,
                     {},
                     false,
                     fragment});
  const auto most = static_cast<std::int64_t>(StatefulReader::kMostPartialOctets);
  EXPECT_LT(octets() - before, most + static_cast<std::int64_t>(Payload::kMostKept) + kMiB);
  EXPECT_GT(octets() - before, most / 2) << "they are kept at all";
  EXPECT_EQ(a.participant.counters().malformed, 0u);
  expect_that_samples_come();
}

TEST_F(Matched, AGapOverMoreNumbersThanThereAreIsNotWalked) {
  constexpr SequenceNumber kFar{std::int64_t{1} << 60};
  for (const auto& guid : writers) {
    forge(Gap{{}, guid.entity, {1000}, SequenceNumberSet(kFar)});
    forge(Gap{{}, guid.entity, {2}, SequenceNumberSet(kFar)});
  }
  EXPECT_LT(octets() - before, kMiB);
  EXPECT_EQ(a.participant.counters().malformed, 0u);
  expect_that_samples_come();
  for (const auto& guid : writers) forge(Gap{{}, guid.entity, {2}, SequenceNumberSet(kFar)});
  EXPECT_EQ(a.listener.lost, 0);
  EXPECT_LT(octets() - before, kMiB);
}

}  // namespace
}  // namespace ddssec::rtps
