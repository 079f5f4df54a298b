// Claims of strangers take bounded memory and no time: floods and forgeries against a whole
// participant, whose memory is counted.
#include <fstream>
#include <unistd.h>

#include <gtest/gtest.h>

#include "rtps/discovery/parameter_table.hpp"
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

// Returns a message of any size with one submessage.
template <class S>
Bytes whole(const GuidPrefix& source, const S& submessage) {
  static Bytes buffer(65536);
  SpanWriter out(buffer);
  Header header;
  header.prefix = source;
  write(out, header);
  write(out, submessage);
  EXPECT_FALSE(out.overflowed());
  return to_bytes(out.view());
}

// An announcement of any participant. It is changed in place.
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

// T60 (docs/attacks.md) and CVE-2026-45092: the answers are bounded as well.
TEST(ParticipantBounds, AMillionFakeParticipants_TakeABoundedPlace) {
  Node a(1);
  Announcement announcement;
  const auto before = octets();
  for (std::uint32_t i = 0; i < 1'000'000; ++i)
    a.participant.receive(announcement.of(i), seconds(1));
  EXPECT_EQ(a.participant.remote_participants().size(), RemoteParticipants::kMaxParticipants);
  EXPECT_EQ(a.participant.counters().refused_discovery,
            1'000'000 - RemoteParticipants::kMaxParticipants);
  EXPECT_LT(a.post.sent.size(), 8 * RemoteParticipants::kMaxParticipants);
  a.post.sent = {};
  EXPECT_LT(octets() - before, 8 * kMiB);
}

// g++ 12 does not destroy the members of an aggregate if a function returns in the middle of its
// initialization.
TEST(ParticipantBounds, APropertyWhoseValueIsCutOff_IsForgotten) {
  Bytes payload = {0, 3, 0, 0, 0x59, 0, 44, 0, 1, 0, 0, 0, 32, 0, 0, 0};
  payload.insert(payload.end(), 31, 'n');
  payload.insert(payload.end(), {0, 0xff, 0, 0, 0, 1, 0, 0, 0});
  ASSERT_FALSE(read_participant_data(payload));
  const auto before = octets();
  for (int i = 0; i < 100; ++i) EXPECT_FALSE(read_participant_data(payload));
  EXPECT_EQ(octets(), before);
}

// One reader, and many writers of another participant that matched it.
struct MatchedParticipants : ::testing::Test {
  static constexpr int kWriters = 16;
  Node a{1}, b{2};
  World world{{&a, &b}};
  std::vector<Guid> writers;
  std::int64_t before = 0;

  void SetUp() override {
    const auto request = [](Qos qos) {
      return EndpointDescription{"Topic", "Type", std::move(qos), true};
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
    a.participant.receive(whole(b.participant.prefix(), submessage), world.now);
  }
  void expect_that_samples_come() {
    a.post.sent = b.post.sent = {};
    for (const auto& guid : writers) {
      Change change;
      change.payload = Payload::copy_of(Bytes(64));
      b.participant.local_endpoints().writer(guid)->write(std::move(change), world.now);
    }
    world.run(100);
    EXPECT_GE(a.listener.changes.size(), writers.size());
  }
};

#if defined(__SANITIZE_ADDRESS__)
// The samples are few, because each is marked octet by octet.
constexpr std::int64_t kIncomplete = 10;
constexpr std::int64_t kTouched = 64 * kMiB;  // the sanitizer notes the state of each allocation
#else
constexpr std::int64_t kIncomplete = 1000;
constexpr std::int64_t kTouched = 4 * kMiB;
#endif

TEST_F(MatchedParticipants, FragmentsThatNeverComplete_TakeABoundedPlace) {
  const Bytes fragment(1024);
  for (std::int64_t number = 1; number <= kIncomplete; ++number)
    for (const auto& guid : writers)
      forge(DataFrag{{},
                     guid.entity,
                     {number},
                     {1},
                     1,
                     1024,
                     StatefulReader::kMaxSample,
                     {},
                     false,
                     fragment});
  const auto most = static_cast<std::int64_t>(HeldOctets::kMaxOfOne);
  EXPECT_LT(octets() - before, most + static_cast<std::int64_t>(Payload::kMaxKept) + kMiB);
  EXPECT_GT(octets() - before, most / 2) << "they are kept at all";
  EXPECT_EQ(a.participant.counters().malformed, 0u);
  expect_that_samples_come();
}

// Returns the octets of this process that are in memory now.
std::int64_t resident() {
  std::ifstream statm("/proc/self/statm");
  std::int64_t size = 0, pages = 0;
  statm >> size >> pages;
  return pages * sysconf(_SC_PAGESIZE);
}

// A datagram of 60 octets that claims 64 Mi fragments of one octet would cost 20 ms of CPU and 128
// MiB.
TEST_F(MatchedParticipants, FragmentsOfOneOctetOfAHugeSample_AreNotTaken) {
  const Bytes octet(1);
  const auto allocated = counted_memory::octets_ever();
  for (std::int64_t number = 1000; number > 0; --number)
    forge(DataFrag{
        {}, writers[0].entity, {number}, {1}, 1, 1, StatefulReader::kMaxSample, {}, false, octet});
  EXPECT_LT(counted_memory::octets_ever() - allocated, kMiB);
  expect_that_samples_come();
}

// The lowest number takes the place of the highest one, so each datagram begins a new sample.
TEST_F(MatchedParticipants, ClaimedSizeOfAFragment_IsNotTouchedBeforeItComes) {
  constexpr auto kSize = PartialSamples::kMinFragmentSize;
  constexpr auto kLast = StatefulReader::kMaxSample / kSize;
  const Bytes fragment(kSize);
  const auto touched = resident();
  for (std::int64_t number = 1000; number > 0; --number)
    forge(DataFrag{{},
                   writers[0].entity,
                   {number},
                   {number % 2 == 0 ? 1 : kLast},
                   1,
                   kSize,
                   StatefulReader::kMaxSample,
                   {},
                   false,
                   fragment});
  EXPECT_LT(resident() - touched, kTouched);
  expect_that_samples_come();
}

// Samples that one participant begins with many writers take no room from those of another
// participant.
TEST(ParticipantBounds, ClaimsOfManyWriters_DoNotDisplaceTheSamplesOfAnotherParticipant) {
  Node a(1);
  MessageSender sender(a.post, a.participant.prefix());
  std::vector<Change> delivered;
  StatefulReader reader({a.participant.prefix(), testing::kReader}, true, sender,
                        [&](Change& change) {
                          delivered.push_back(std::move(change));
                          return true;
                        });
  constexpr std::uint32_t kClaimed = 1 << 20;
  reader.limit({.held_octets = 8 * kClaimed, .held_octets_of_one = 4 * kClaimed});
  const auto hostile = GuidPrefix::from(Bytes(12, 0x77));
  const auto honest = GuidPrefix::from(Bytes(12, 0x99));
  const auto writer = [](std::uint8_t i) { return EntityId{{0, 0, i, 0x02}}; };
  for (std::uint8_t i = 0; i < 100; ++i) reader.match({{hostile, writer(i)}, true}, seconds(1));
  reader.match({{honest, writer(1)}, true}, seconds(1));
  const Bytes half(32768);
  const auto send_half = [&](std::uint32_t number) {
    reader.on_data_frag(honest, {{}, writer(1), {1}, {number}, 1, 32768, 65536, {}, false, half},
                        {}, false, KeyAge::newest);
  };
  send_half(1);
  for (std::uint8_t i = 0; i < 100; ++i)
    for (std::int64_t number = 1; number <= 4; ++number)
      reader.on_data_frag(hostile,
                          {{}, writer(i), {number}, {1}, 1, 32768, kClaimed, {}, false, half}, {},
                          false, KeyAge::newest);
  send_half(2);
  EXPECT_EQ(delivered.size(), 1u);
}

// The first sample of each writer is missing, and the others wait for it.
TEST_F(MatchedParticipants, SamplesThatCameTooEarly_TakeABoundedPlace) {
  const Bytes large(60'000);
  for (std::int64_t number = 2; number <= kIncomplete / 2; ++number)
    for (const auto& guid : writers)
      forge(Data{{}, guid.entity, {number}, {}, PayloadKind::data, large});
  const auto most = static_cast<std::int64_t>(HeldOctets::kMaxOfOne);
  const auto rounded = most / 4;
  EXPECT_LT(octets() - before, most + rounded + kMiB);
  EXPECT_EQ(a.participant.counters().malformed, 0u);
  expect_that_samples_come();
}

// Returns an endpoint whose announcement is as large as it may be.
EndpointData large_endpoint(const GuidPrefix& prefix, std::uint32_t number) {
  EndpointData data;
  data.guid = {prefix,
               {{static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8),
                 static_cast<std::uint8_t>(number), 0x02}}};
  data.topic_name = "Topic " + std::to_string(number);
  data.type_name = std::string(kMaxNameLength, 't');
  data.qos.user_data = data.qos.topic_data = data.qos.group_data = Bytes(kMaxOpaqueOctets, 7);
  data.qos.partition.assign(kMaxPartitions, std::string(kMaxNameLength, 'p'));
  return data;
}

Data announced(const EndpointData& data, std::int64_t number, Bytes& buffer) {
  buffer.resize(65'000);
  SpanWriter out(buffer);
  write_payload(out, data);
  return {{},
          is_writer(data.guid.entity) ? kPublicationsWriter : kSubscriptionsWriter,
          {number},
          {},
          PayloadKind::data,
          out.view()};
}

// The writer's heartbeat says where its numbers begin, so all of them are taken at once.
TEST_F(MatchedParticipants, EndpointsOfOneParticipant_TakeABoundedPlace) {
  constexpr std::int64_t kFirst = 1000;
  forge(Heartbeat{{}, kPublicationsWriter, {kFirst}, {kFirst}, 1000, true});
  Bytes buffer;
  for (std::uint32_t i = 0; i < 4000; ++i)
    forge(announced(large_endpoint(b.participant.prefix(), 0x10000 + i), kFirst + i, buffer));
  EXPECT_LT(
      octets() - before,
      static_cast<std::int64_t>(RemoteParticipants::kMaxEndpointOctetsPerParticipant) + 8 * kMiB);
  EXPECT_GT(a.participant.counters().refused_discovery, 0u);
  const auto codes = a.events.codes();
  EXPECT_EQ(std::ranges::count(codes, Code::rtps_too_many_endpoints), 1) << "said once";
  expect_that_samples_come();
}

// Without the first one, announcements wait, and so do the messages that assert liveliness.
TEST_F(MatchedParticipants, AnnouncementsThatCameTooEarly_TakeABoundedPlace) {
  Bytes buffer;
  for (std::uint32_t i = 0; i < 1500; ++i)
    forge(announced(large_endpoint(b.participant.prefix(), 0x10000 + i), 1000 + i, buffer));
  const Bytes claimed(1024);
  for (const auto& topic : {kSubscriptionsWriter, kParticipantMessageWriter})
    for (std::int64_t number = 1000; number < 1004; ++number)
      forge(DataFrag{
          {}, topic, {number}, {1}, 1, 1024, StatefulReader::kMaxSample, {}, false, claimed});
  EXPECT_LT(octets() - before, 24 * kMiB);
  expect_that_samples_come();
}

TEST_F(MatchedParticipants, AGapOverMoreNumbersThanThereAre_IsNotWalked) {
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

// With eight small messages each writer makes the reader note two thousand numbers.
TEST(ParticipantBounds, NumbersThatAreSkipped_TakeABoundedPlace) {
  Node a(1);
  MessageSender sender(a.post, a.participant.prefix());
  StatefulReader reader({a.participant.prefix(), testing::kReader}, true, sender,
                        [](Change&) { return true; });
  constexpr std::size_t kMax = 1 << 20;
  reader.limit({.held_octets = kMax});
  const auto crowd = GuidPrefix::from(Bytes(12, 0x77));
  const auto writer = [](std::uint8_t i) { return EntityId{{0, 0, i, 0x02}}; };
  for (std::uint8_t i = 0; i < 100; ++i) reader.match({{crowd, writer(i)}, true}, seconds(1));
  const auto before = octets();
  for (std::uint8_t i = 0; i < 100; ++i)
    for (std::int64_t number = 10; number < 10 + 256 * 8; number += 256) {
      SequenceNumberSet irrelevant{SequenceNumber{number}};
      for (std::int64_t bit = 0; bit < 256; ++bit) irrelevant.insert({number + bit});
      reader.on_gap(crowd, Gap{{}, writer(i), {number}, irrelevant}, KeyAge::newest);
    }
  EXPECT_LT(octets() - before, static_cast<std::int64_t>(kMax) + kMiB / 4);
  EXPECT_GT(octets() - before, static_cast<std::int64_t>(kMax) / 2) << "they are noted at all";
}

// Four participants that announce as much as they can leave room for a fifth one.
TEST(ParticipantBounds, ParticipantThatAnnouncesMuch_TakesNoPlaceFromOthers) {
  Node a(1);
  Announcement announcement;
  const auto say = [&](std::uint32_t participant, std::uint32_t endpoints) {
    const auto told = announcement.of(participant);
    const auto prefix = GuidPrefix::from(told.subspan(8, 12));
    a.participant.receive(told, seconds(1));
    for (std::uint32_t i = 0; i < endpoints; ++i) {
      Bytes buffer;
      EndpointData data;
      data.guid = {prefix,
                   {{static_cast<std::uint8_t>(i >> 16), static_cast<std::uint8_t>(i >> 8),
                     static_cast<std::uint8_t>(i), 0x02}}};
      data.topic_name = data.type_name = "T";
      a.participant.receive(whole(prefix, announced(data, 1 + i, buffer)), seconds(1));
    }
  };
  for (std::uint32_t i = 1; i <= 4; ++i) say(i, RemoteParticipants::kMaxEndpointsPerParticipant);
  constexpr auto kFree = RemoteParticipants::kMaxEndpointsPerParticipant / 2;
  EXPECT_EQ(a.participant.remote_participants().endpoints().size(),
            RemoteParticipants::kMaxEndpoints - kFree)
      << "the fourth leaves as much free as it takes";
  say(5, 50);
  EXPECT_EQ(a.participant.remote_participants().endpoints().size(),
            RemoteParticipants::kMaxEndpoints - kFree + 50);
  EXPECT_EQ(a.events.codes(), std::vector{Code::rtps_too_many_endpoints}) << "about the fourth";
}

}  // namespace
}  // namespace ddssec::rtps
