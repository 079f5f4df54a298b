#include "plugins/cryptography/announced_endpoints.hpp"

#include <optional>

#include <gtest/gtest.h>

#include "plugins/cryptography/builtin_checks.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr EntityId kPublications{{0xff, 0, 3, 0xc2}}, kSubscriptions{{0xff, 0, 4, 0xc2}};
constexpr std::size_t kUserData = 60'000;

EntityId endpoint(std::uint32_t number) {
  return {{static_cast<std::uint8_t>(number >> 16), static_cast<std::uint8_t>(number >> 8),
           static_cast<std::uint8_t>(number), 2}};
}

/// Little endian: user data, and what it is about.
Bytes announcement(std::uint32_t number, std::size_t user_data) {
  Bytes list = {0, 3, 0, 0};
  append(list, 0x2c, 2, true);
  append(list, user_data, 2, true);
  list.resize(list.size() + user_data);
  append(list, 0x5a, 2, true);
  append(list, 16, 2, true);
  append(list, kPeer.view());
  append(list, endpoint(number).view());
  append(list, 1, 4, true);
  return list;
}

/// What the end of an endpoint has as payload: its name.
Bytes name_only(std::uint32_t number) {
  Bytes list = {0, 3, 0, 0};
  append(list, 0x5a, 2, true);
  append(list, 16, 2, true);
  append(list, kPeer.view());
  append(list, endpoint(number).view());
  append(list, 1, 4, true);
  return list;
}

constexpr std::uint8_t kDisposed = 1, kUnregistered = 2, kFiltered = 4;

/// Little endian, after the ids of reader and writer.
Bytes of_writer(std::uint8_t id, const EntityId& writer,
                std::initializer_list<std::uint32_t> words) {
  Bytes out = {id, 1};
  append(out, 8 + 4 * words.size(), 2, true);
  append(out, EntityId{}.view());
  append(out, writer.view());
  for (const auto word : words) append(out, word, 4, true);
  return out;
}

struct AnnouncedEndpointsTest : ::testing::Test {
  AnnouncedEndpointsTest() { peers.peer.announced.count_for(account); }
  Code announce(std::uint32_t endpoint, std::size_t user_data = kUserData,
                const EntityId& writer = kPublications) {
    return announce_under(next_number++, endpoint, user_data, writer);
  }
  Code announce_under(std::uint32_t number, std::uint32_t endpoint,
                      std::size_t user_data = kUserData, const EntityId& writer = kPublications) {
    const DataMessage message{
        .writer = writer, .number = number, .payload = announcement(endpoint, user_data)};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  Code dispose(std::uint32_t endpoint, std::uint8_t status) {
    return dispose_under(next_number++, endpoint, status);
  }
  Code dispose_under(std::uint32_t number, std::uint32_t endpoint, std::uint8_t status) {
    return dispose_as(number, status_info({status}), name_only(endpoint));
  }
  Code dispose_as(std::uint32_t number, Bytes inline_qos, Bytes payload) {
    const DataMessage message{.writer = kPublications,
                              .flags = 0x06,
                              .number = number,
                              .inline_qos = std::move(inline_qos),
                              .payload = std::move(payload)};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  static Bytes status_info(std::initializer_list<std::uint8_t> values) {
    Bytes out;
    for (const auto value : values) {
      append(out, 0x71, 2, true);
      append(out, 4, 2, true);
      append(out, value, 4, false);
    }
    append(out, 1, 4, true);
    return out;
  }
  Code fragment(std::uint32_t number, const Bytes& sample, std::uint32_t first,
                std::uint16_t size) {
    const auto begin = std::size_t{first - 1} * size;
    const auto end = std::min<std::size_t>(begin + size, sample.size());
    const DataMessage message{
        .writer = kPublications,
        .number = number,
        .payload = Bytes(sample.begin() + static_cast<long>(begin),
                         sample.begin() + static_cast<long>(end)),
        .fragment = Fragment{
            .first = first, .size = size, .whole = static_cast<std::uint32_t>(sample.size())}};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  /// All fragments, as long as they pass.
  Code fragments(std::uint32_t number, const Bytes& sample) {
    constexpr std::uint16_t kSize = 1344;
    auto code = Code{};
    for (std::uint32_t first = 1; code == Code{} && std::size_t{first - 1} * kSize < sample.size();
         ++first)
      code = fragment(number, sample, first, kSize);
    return code;
  }
  void tell(const Bytes& submessage) {
    EXPECT_EQ(code_of(check_builtin_source(submessage, kPeer, peers)), Code{});
  }
  void acknowledge(std::uint32_t until) {
    for (const auto& writer : {kPublications, kSubscriptions})
      peers.peer.announced.acknowledged(*builtin_topic_of(writer), until);
  }
  void acknowledge() { acknowledge(next_number); }
  /// Until one more is refused.
  std::uint32_t fill() {
    while (announce(next) == Code{}) ++next;
    acknowledge();
    return next;
  }
  std::size_t held() const { return account->sum(); }
  std::size_t held_again() const { return account->sum(AnnouncedOctets::Heard::again); }
  static std::size_t cost(std::size_t user_data) {
    return announcement(1, user_data).size() + AnnouncedOctets::kOfEach;
  }
  static std::size_t cost_of_end() { return name_only(1).size() + AnnouncedOctets::kOfEach; }
  std::shared_ptr<AnnouncedOctets> account = std::make_shared<AnnouncedOctets>();
  OneOwner peers;
  std::uint32_t next = 1;
  std::uint32_t next_number = 1;
};

TEST_F(AnnouncedEndpointsTest, AreBoundedByWhatTheyHold) {
  const auto one = announcement(1, kUserData).size() + AnnouncedOctets::kOfEach;
  EXPECT_EQ(fill(), AnnouncedOctets::kMost / one + 1);
  EXPECT_EQ(announce(next), Code::builtin_source_unreadable);
}

TEST_F(AnnouncedEndpointsTest, AreBoundedByTheirNumber) {
  for (; announce(next, 0) == Code{}; ++next)
    ASSERT_LE(next, AnnouncedOctets::kMost / AnnouncedOctets::kOfEach);
}

TEST_F(AnnouncedEndpointsTest, CountOnceByEachWriterWhateverTheyWereBefore) {
  for (int again = 0; again < 3000; ++again) {
    ASSERT_EQ(announce(1), Code{});
    ASSERT_EQ(announce(1, kUserData, kSubscriptions), Code{});
    acknowledge();
  }
}

// The host keeps what comes before a number that is missing, all of it.
TEST_F(AnnouncedEndpointsTest, CountByTheirNumberUntilTheyAreAcknowledged) {
  int passed = 0;
  while (announce(1) == Code{}) ASSERT_LE(++passed, 2000);
  acknowledge();
  EXPECT_EQ(announce(1), Code{});
}

TEST_F(AnnouncedEndpointsTest, ThatAreGoneMakeRoomOnceTheHostHasAcknowledgedIt) {
  for (const auto status : {kDisposed, kUnregistered}) {
    ASSERT_EQ(announce(1), Code{});
    acknowledge();
    EXPECT_EQ(held(), cost(kUserData));
    ASSERT_EQ(dispose(1, status), Code{});
    EXPECT_EQ(held(), cost(kUserData) + cost_of_end());
    acknowledge();
    EXPECT_EQ(held(), 0u);
  }
}

TEST_F(AnnouncedEndpointsTest, ThatAreFilteredStay) {
  ASSERT_EQ(announce(1), Code{});
  ASSERT_EQ(dispose(1, kFiltered), Code{});
  acknowledge();
  EXPECT_EQ(held(), cost(kUserData));
}

// The host acknowledges what it refuses, and keeps the former announcement.
TEST_F(AnnouncedEndpointsTest, AnnouncedAgainSmaller_CountAsTheLargest) {
  ASSERT_EQ(announce(1), Code{});
  ASSERT_EQ(announce(1, 0), Code{});
  acknowledge();
  EXPECT_EQ(held(), cost(kUserData));
  ASSERT_EQ(dispose(1, kDisposed), Code{});
  acknowledge();
  EXPECT_EQ(held(), 0u);
}

TEST_F(AnnouncedEndpointsTest, EndedInAFormThatAHostMayRefuse_StayCounted) {
  const auto inline_qos = [](std::initializer_list<std::pair<std::uint16_t, Bytes>> parameters) {
    Bytes out;
    for (const auto& [id, value] : parameters) {
      append(out, id, 2, true);
      append(out, value.size(), 2, true);
      append(out, value);
    }
    append(out, 1, 4, true);
    return out;
  };
  const Bytes disposed = {0, 0, 0, kDisposed};
  Bytes key_hash = to_bytes(kPeer.view());
  append(key_hash, endpoint(1).view());
  const Bytes short_hash = to_bytes(kPeer.view());
  Bytes named_twice = name_only(1);
  named_twice.resize(named_twice.size() - 4);
  append(named_twice, BytesView(name_only(1)).subspan(4));
  Bytes with_participant = name_only(1);
  with_participant.insert(with_participant.begin() + 4, {0x50, 0, 16, 0});
  with_participant.insert(with_participant.begin() + 8, key_hash.begin(), key_hash.end());
  const std::pair<Bytes, Bytes> unusual[] = {
      {inline_qos({{0x71, disposed}}), announcement(1, 0)},
      {inline_qos({{0x71, disposed}, {0x71, disposed}}), name_only(1)},
      {inline_qos({{0x71, {0, 0, 0, 9}}}), name_only(1)},
      {inline_qos({{0x71, {1, 0, 0, kDisposed}}}), name_only(1)},
      {inline_qos({{0x71, disposed}, {0x70, short_hash}}), name_only(1)},
      {inline_qos({{0x71, disposed}, {0x70, key_hash}, {0x70, key_hash}}), name_only(1)},
      {inline_qos({{0x71, disposed}, {0x1d, disposed}}), name_only(1)},
  };
  ASSERT_EQ(announce(1), Code{});
  for (const auto& [qos, payload] : unusual) {
    EXPECT_EQ(dispose_as(next_number++, qos, payload), Code{});
    acknowledge();
    EXPECT_EQ(held(), cost(kUserData));
  }
  EXPECT_EQ(dispose_as(next_number++, inline_qos({{0x71, disposed}}), named_twice),
            Code::builtin_source_unreadable);
  for (const auto& payload : {name_only(1), with_participant}) {
    ASSERT_EQ(announce(1), Code{});
    ASSERT_EQ(dispose_as(next_number++, inline_qos({{0x70, key_hash}, {0x71, disposed}}), payload),
              Code{});
    acknowledge();
    EXPECT_EQ(held(), 0u) << payload.size();
  }
}

// Before: the endpoint did not count any more, and the host kept it.
TEST_F(AnnouncedEndpointsTest, DoNotEndByANumberThatTheHostPassesOver) {
  ASSERT_EQ(announce(1), Code{});
  ASSERT_EQ(announce(2), Code{});
  acknowledge();
  for (const std::uint32_t number : {1, 2}) EXPECT_EQ(dispose_under(number, 2, kDisposed), Code{});
  EXPECT_EQ(held(), 2 * cost(kUserData));
}

TEST_F(AnnouncedEndpointsTest, DoNotEndByANumberThatTheHostMayHaveSkipped) {
  constexpr std::uint8_t kGap = 0x08, kHeartbeat = 0x07;
  const std::vector<Bytes> ways = {of_writer(kGap, kPublications, {0, 2, 0, 3, 0}),
                                   of_writer(kGap, kPublications, {0, 1, 0, 1, 32, 0x40000000}),
                                   of_writer(kHeartbeat, kPublications, {0, 3, 0, 9, 1})};
  for (const bool before : {true, false}) {
    for (const auto& way : ways) {
      next_number = 1;
      peers.peer.announced.~AnnouncedEndpoints();
      new (&peers.peer.announced) AnnouncedEndpoints();
      peers.peer.announced.count_for(account);
      ASSERT_EQ(announce(1), Code{});
      if (before) tell(way);
      ASSERT_EQ(dispose_under(2, 1, kDisposed), Code{});
      if (!before) tell(way);
      EXPECT_EQ(held(), cost(kUserData) + cost_of_end());
      acknowledge(3);
      EXPECT_EQ(held(), cost(kUserData));
    }
  }
}

TEST_F(AnnouncedEndpointsTest, EndThoughOtherNumbersWereSkipped) {
  ASSERT_EQ(announce_under(1, 1), Code{});
  tell(of_writer(0x08, kPublications, {0, 2, 0, 5, 0}));
  ASSERT_EQ(dispose_under(5, 1, kDisposed), Code{});
  acknowledge(6);
  EXPECT_EQ(held(), 0u);
}

TEST_F(AnnouncedEndpointsTest, OneNumberSaysOneThing) {
  ASSERT_EQ(announce_under(1, 1), Code{});
  EXPECT_EQ(announce_under(1, 1), Code{}) << "it came again";
  EXPECT_EQ(announce_under(1, 2), Code::builtin_source_unreadable);
  EXPECT_EQ(announce_under(1, 1, 10), Code::builtin_source_unreadable);
  EXPECT_EQ(dispose_under(1, 1, kDisposed), Code::builtin_source_unreadable);
  const DataMessage empty{.writer = kPublications, .flags = 0, .number = 2, .payload = {}};
  tell(empty.octets());
  EXPECT_EQ(dispose_under(2, 1, kDisposed), Code::builtin_source_unreadable)
      << "the host went on to the next number";
  EXPECT_EQ(fragment(1, announcement(1, kUserData), 1, 1344), Code::builtin_source_unreadable);
}

TEST_F(AnnouncedEndpointsTest, OneAnnouncementSaysOneThing) {
  DataMessage message{.writer = kPublications,
                      .flags = 0x06,
                      .inline_qos = status_info({kDisposed, 0}),
                      .payload = announcement(1, 0)};
  EXPECT_EQ(code_of(check_builtin_source(message.octets(), kPeer, peers)),
            Code::builtin_source_unreadable);
  const auto one = announcement(1, 0), two = announcement(2, 0);
  message.inline_qos = status_info({});
  message.payload.assign(one.begin(), one.end() - 4);  // without its sentinel
  message.payload.insert(message.payload.end(), two.begin() + 4, two.end());
  EXPECT_EQ(code_of(check_builtin_source(message.octets(), kPeer, peers)),
            Code::builtin_source_unreadable);
}

// To a participant that is made later: new to it, and once more in the host.
TEST_F(AnnouncedEndpointsTest, ThatComeAgainLaterCountOnceElsewhere) {
  ASSERT_EQ(announce_under(1, 1), Code{});
  acknowledge(2);
  for (int turn = 0; turn < 2; ++turn) EXPECT_EQ(announce_under(1, 1), Code{});
  EXPECT_EQ(held(), cost(kUserData));
  EXPECT_EQ(held_again(), cost(kUserData));
  EXPECT_EQ(announce_under(1, 2), Code{});
  EXPECT_EQ(held(), cost(kUserData));
  EXPECT_EQ(held_again(), 2 * cost(kUserData));
  ASSERT_EQ(dispose_under(2, 1, kDisposed), Code{});
  acknowledge(3);
  EXPECT_EQ(held(), 0u);
  EXPECT_EQ(held_again(), cost(kUserData));
  peers.peer.announced.count_for(std::make_shared<AnnouncedOctets>());
  EXPECT_EQ(held_again(), 0u) << "it left the account";
}

// Before: endpoints that had ended counted again, and nothing took them back.
TEST_F(AnnouncedEndpointsTest, ThatAStrangerRepeatsTakeNoRoomFromNewOnes) {
  constexpr std::uint32_t kMany = 2 * AnnouncedOctets::kMost / kUserData;
  for (std::uint32_t number = 1; number <= 2 * kMany; number += 2) {
    ASSERT_EQ(announce_under(number, number), Code{});
    ASSERT_EQ(dispose_under(number + 1, number, kDisposed), Code{});
    acknowledge(number + 2);
  }
  Code last{};
  for (std::uint32_t number = 1; number <= 2 * kMany; number += 2)
    last = announce_under(number, number);
  EXPECT_EQ(last, Code::builtin_source_unreadable) << "these are bounded, too";
  EXPECT_LE(held_again(), AnnouncedOctets::kMost);
  EXPECT_EQ(held(), 0u);
  EXPECT_EQ(announce_under(2 * kMany + 1, 1), Code{});
}

TEST_F(AnnouncedEndpointsTest, InFragmentsCountFromTheFirstOn) {
  const auto sample = announcement(1, kUserData);
  EXPECT_EQ(fragment(1, sample, 1, 1344), Code{});
  EXPECT_EQ(held(), cost(kUserData));
  EXPECT_EQ(fragments(1, sample), Code{});
  EXPECT_EQ(held(), cost(kUserData));
  acknowledge(2);
  EXPECT_EQ(held(), cost(kUserData));
  EXPECT_EQ(dispose_under(2, 1, kDisposed), Code{});
  acknowledge(3);
  EXPECT_EQ(held(), 0u);
}

// Before: 128 of 23 MB each that the host held for one endpoint, without an end in sight.
TEST_F(AnnouncedEndpointsTest, InFragmentsAreBoundedWhileOneBeforeThemIsMissing) {
  const auto large = announcement(1, 65'000);
  std::uint32_t number = 2;
  while (fragments(number, large) == Code{}) {
    peers.time += FragmentWalks::kKept;
    ASSERT_LE(++number, 2000u);
  }
  EXPECT_LE(held(), AnnouncedOctets::kMost);
  Bytes huge(FragmentWalks::kMostOctets + 1);
  EXPECT_EQ(fragment(number + 1, huge, 1, 60'000), Code::builtin_source_unreadable);
}

TEST_F(AnnouncedEndpointsTest, ARefusedFirstFragmentDoesNotCount) {
  auto sample = announcement(1, kUserData);
  sample[1] = 9;  // no parameter list
  EXPECT_EQ(fragment(1, sample, 1, 1344), Code::builtin_source_unreadable);
  EXPECT_EQ(held(), 0u);
}

/// An engine whose host believes any source, and a peer that goes on and on.
struct AcknowledgedEndpoints : ::testing::Test {
  static constexpr int kTimes = 2 * AnnouncedOctets::kMost / kUserData;

  void meet(ProtectionKind rtps) {
    two.emplace(rtps, PropertyList{}, Options{.host_checks_sources = false});
    auto secret = shared_secret(5);
    secret.peer_prefix = kPeer;
    for (auto* side : {&two->a, &two->b})
      side->remote = side->factory()
                         .register_matched_remote_participant(side->participant, {8}, {7}, secret)
                         .value();
    if (rtps != ProtectionKind::none) return two->exchange_participant_tokens();
    auto attributes = endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none);
    attributes.is_builtin = true;
    ends = two->endpoints(attributes);
  }
  /// The host has the sample with that number, and tells its writer.
  static Bytes acknacks(const EntityId& writer, std::uint32_t number) {
    return of_writer(submessage_id::kAckNack, writer, {0, number + 1, 0, number});
  }
  static Bytes announces(const EntityId& writer, std::uint32_t number) {
    return DataMessage{.writer = writer, .number = number, .payload = announcement(1, kUserData)}
        .octets();
  }
  /// By the peer, or to it.
  static Bytes message(const GuidPrefix& from, const Bytes& submessages) {
    Bytes out = {'R', 'T', 'P', 'S', 2, 5, 1, 16};
    append(out, from.view());
    append(out, Bytes{0x0e, 1, 12, 0});
    append(out, kPeer.view());
    append(out, submessages);
    return out;
  }
  std::optional<TwoSides> two;
  WriterToReader ends;
};

// Before: the host's acknowledgments were not looked at.
TEST_F(AcknowledgedEndpoints, CountOnceUnderKeysOfTheirWriters) {
  meet(ProtectionKind::none);
  for (std::uint32_t number = 1; number <= kTimes; ++number) {
    ASSERT_TRUE(decode_submessage(
        *two, ends, encode_submessage(*two, ends, announces(kPublications, number)).value()))
        << number;
    ASSERT_TRUE(encode_reply(*two, ends, acknacks(kPublications, number)));
  }
  EXPECT_TRUE(two->b.events.codes.empty()) << two->b.events.last;
}

TEST_F(AcknowledgedEndpoints, CountOnceInProtectedMessages) {
  constexpr EntityId kClear{{0, 0, 3, 0xc2}};
  meet(ProtectionKind::encrypt);
  for (std::uint32_t number = 1; number <= kTimes; ++number) {
    const auto encoded = encode_message(*two, message(kPeer, announces(kClear, number)));
    const auto decoded = decode_message(*two, encoded.value());
    ASSERT_TRUE(decoded);
    ASSERT_GT(decoded->size(), kUserData) << number << ' ' << two->b.events.last;
    ASSERT_TRUE(into_bytes(1000, [&](MutableBytes out) {
      return two->b.transform().encode_rtps_message(
          two->b.participant, {&two->b.remote, 1}, message(kVictim, acknacks(kClear, number)), out);
    }));
  }
}

TEST(SkippedNumbers, AreKnownExactlyWhereThereAreFew) {
  SkippedNumbers skipped;
  skipped.add(5, 7);
  skipped.add(10, 12);
  skipped.add(7, 8);
  skipped.add(3, 3);
  for (std::uint64_t number = 0; number < 15; ++number)
    EXPECT_EQ(skipped.contains(number),
              (number >= 5 && number < 8) || (number >= 10 && number < 12))
        << number;
  skipped.forget_below(8);
  EXPECT_FALSE(skipped.contains(6));
  EXPECT_TRUE(skipped.contains(11));
  skipped.add(0, ~0ull);
  EXPECT_TRUE(skipped.contains(9));
}

TEST(SkippedNumbers, OfVeryManyNoneIsMissed) {
  SkippedNumbers skipped;
  for (std::uint64_t number = 0; number < 1000; ++number) skipped.add(2 * number, 2 * number + 1);
  for (std::uint64_t number = 0; number < 1000; ++number) EXPECT_TRUE(skipped.contains(2 * number));
  EXPECT_FALSE(skipped.contains(1997));
}

TEST(AnnouncementAccounts, AreSharedByTheParticipantsOfACertificate) {
  const auto& topic = *builtin_topic_of(kPublications);
  AnnouncementAccounts accounts;
  constexpr auto kHalf = AnnouncedOctets::kMost / 2;
  const auto announces = [&](AnnouncedEndpoints& endpoints, std::uint64_t number,
                             std::size_t octets) {
    return endpoints
        .note(topic, {number, Announcement::Kind::announces, endpoint(1),
                      octets - AnnouncedOctets::kOfEach})
        .has_value();
  };
  AnnouncedEndpoints first, other;
  first.count_for(accounts.of(1));
  other.count_for(accounts.of(2));
  {
    AnnouncedEndpoints second;
    second.count_for(accounts.of(1));
    EXPECT_TRUE(announces(first, 1, kHalf));
    EXPECT_FALSE(announces(second, 1, kHalf + 1));
    EXPECT_TRUE(announces(other, 1, kHalf));
    EXPECT_TRUE(announces(second, 1, kHalf));
    EXPECT_FALSE(announces(first, 2, kHalf));
  }
  EXPECT_TRUE(announces(first, 2, kHalf)) << "the second has left";
}

// ---- announcements that hide how an endpoint is protected

constexpr std::uint16_t kSecurityInfo = 0x1004;
constexpr std::uint32_t kValid = 0x80000000;

/// Before the sentinel of a list: the attributes, in an EndpointSecurityInfo.
Bytes with_info(Bytes list, std::uint32_t attributes, std::uint16_t id = kSecurityInfo,
                std::uint16_t size = 8) {
  const Bytes sentinel(list.end() - 4, list.end());
  list.resize(list.size() - 4);
  append(list, id, 2, true);
  append(list, size, 2, true);
  if (size >= 4) append(list, attributes, 4, true);
  if (size > 4) list.resize(list.size() + size - 4);
  append(list, sentinel);
  return list;
}

struct HiddenEndpointsTest : AnnouncedEndpointsTest {
  Code hear(const Bytes& payload, const EntityId& writer = kPublications) {
    const DataMessage message{.writer = writer, .number = next_number++, .payload = payload};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  bool hides(const Bytes& payload) {
    OneOwner fresh;
    const DataMessage message{.writer = kPublications, .payload = payload};
    EXPECT_EQ(code_of(check_builtin_source(message.octets(), kPeer, fresh)), Code{});
    EXPECT_FALSE(fresh.peer.announced.hides_readers());
    return fresh.peer.announced.hides_writers();
  }
  const AnnouncedEndpoints& announced() const { return peers.peer.announced; }
};

TEST_F(HiddenEndpointsTest, OneValidSecurityInfo_HidesNothing) {
  const auto plain = announcement(1, 16);
  EXPECT_FALSE(hides(with_info(plain, kValid)));
  EXPECT_FALSE(hides(with_info(plain, kValid | 3, kSecurityInfo, 12)));
  EXPECT_TRUE(hides(plain));
  EXPECT_TRUE(hides(with_info(plain, 0)));
  EXPECT_TRUE(hides(with_info(plain, 0x7fffffff)));
  EXPECT_TRUE(hides(with_info(plain, kValid, kSecurityInfo, 0)));
  for (const auto id : {0x5004, 0x9004, 0xd004}) {
    const auto flagged = static_cast<std::uint16_t>(id);
    EXPECT_TRUE(hides(with_info(plain, kValid, flagged))) << id;
    EXPECT_TRUE(hides(with_info(with_info(plain, kValid), 0, flagged))) << id;
  }
  EXPECT_TRUE(hides(with_info(with_info(plain, kValid), kValid)));
  auto twice = plain;
  for (int i = 0; i < 256; ++i) twice = with_info(twice, kValid);
  EXPECT_TRUE(hides(with_info(twice, kValid)));
}

TEST_F(HiddenEndpointsTest, Writers_AreToldApartFromReaders) {
  EXPECT_EQ(hear(announcement(1, 16), kSubscriptions), Code{});
  EXPECT_TRUE(announced().hides_readers());
  EXPECT_FALSE(announced().hides_writers());
  EXPECT_EQ(hear(announcement(1, 16), {{0, 0, 3, 0xc2}}), Code{});
  EXPECT_TRUE(announced().hides_writers()) << "in the clear, inside of a protected message";
}

TEST_F(HiddenEndpointsTest, EndOfAnEndpoint_HidesNothing) {
  EXPECT_EQ(hear(with_info(announcement(1, 16), kValid)), Code{});
  EXPECT_EQ(dispose(1, kDisposed | kUnregistered), Code{});
  acknowledge();
  EXPECT_FALSE(announced().hides_writers());
}

TEST_F(HiddenEndpointsTest, RepeatedAfterAcknowledgement_Counts) {
  EXPECT_EQ(hear(with_info(announcement(1, 16), kValid)), Code{});
  acknowledge();
  next_number = 1;
  EXPECT_EQ(hear(announcement(2, 16)), Code{});
  EXPECT_TRUE(announced().hides_writers());
}

TEST_F(HiddenEndpointsTest, InFragments_IsFound) {
  EXPECT_EQ(fragments(1, with_info(announcement(1, 6'000), kValid)), Code{});
  EXPECT_FALSE(announced().hides_writers());
  EXPECT_EQ(fragments(2, announcement(2, 6'000)), Code{});
  EXPECT_TRUE(announced().hides_writers());
}

TEST_F(HiddenEndpointsTest, SecuredEndpoints_AreKnownUntilTheirEnd) {
  const auto is_known = [&] { return announced().has_secured(endpoint(1), true); };
  EXPECT_FALSE(is_known());
  EXPECT_EQ(hear(announcement(1, 16), {{0, 0, 3, 0xc2}}), Code{});
  EXPECT_FALSE(is_known()) << "announced in the clear";
  EXPECT_EQ(hear(announcement(1, 16)), Code{});
  EXPECT_TRUE(is_known());
  EXPECT_FALSE(announced().has_secured(endpoint(1), false));
  EXPECT_FALSE(announced().has_secured(endpoint(2), true));
  acknowledge();
  EXPECT_TRUE(is_known());
  EXPECT_EQ(dispose(1, kDisposed), Code{});
  acknowledge();
  EXPECT_FALSE(is_known());
}

}  // namespace
}  // namespace ddssec::cryptography
