// How much endpoints of a peer count, and until when.
#include "tests/unit/cryptography/announcements.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

TEST_F(AnnouncedEndpointsTest, OctetsTheyHold_AreBounded) {
  const auto one = announcement(1, kUserData).size() + AnnouncedOctets::kOfEach;
  EXPECT_EQ(fill(), AnnouncedOctets::kMax / one + 1);
  EXPECT_EQ(announce(next), Code::builtin_source_unreadable);
}

TEST_F(AnnouncedEndpointsTest, Number_IsBounded) {
  for (; announce(next, 0) == Code{}; ++next)
    ASSERT_LE(next, AnnouncedOctets::kMax / AnnouncedOctets::kOfEach);
  EXPECT_EQ(announce(next, 0), Code::builtin_source_unreadable);
  EXPECT_EQ(next, AnnouncedOctets::kMax / cost(0) + 1)
      << "fewer were accepted than the octets allow";
}

TEST_F(AnnouncedEndpointsTest, RepeatedByEachWriter_CountOnce) {
  for (int again = 0; again < 3000; ++again) {
    ASSERT_EQ(announce(1), Code{});
    ASSERT_EQ(announce(1, kUserData, kSubscriptions), Code{});
    acknowledge();
  }
}

// While a number is missing, the host keeps all announcements before it.
TEST_F(AnnouncedEndpointsTest, UntilAcknowledged_CountByTheirNumber) {
  int passed = 0;
  while (announce(1) == Code{}) ASSERT_LE(++passed, 2000);
  acknowledge();
  EXPECT_EQ(announce(1), Code{});
}

TEST_F(AnnouncedEndpointsTest, GoneOnes_MakeRoomOnceTheHostHasAcknowledgedIt) {
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

TEST_F(AnnouncedEndpointsTest, EndedOnes_AreKnownUpToALimit) {
  const auto& announced = peers.peer.announced;
  ASSERT_EQ(announce(1, 0), Code{});
  EXPECT_FALSE(announced.has_ended(endpoint(1), true));
  ASSERT_EQ(dispose(1, kDisposed), Code{});
  ASSERT_EQ(dispose(2, kDisposed), Code{});
  acknowledge();
  EXPECT_TRUE(announced.has_ended(endpoint(1), true));
  EXPECT_FALSE(announced.has_ended(endpoint(1), false));
  EXPECT_FALSE(announced.has_ended(endpoint(2), true)) << "it was never announced";
  for (std::uint32_t more = 0; more < AnnouncedEndpoints::kMaxEnded; ++more) {
    ASSERT_EQ(announce(3 + more, 0), Code{});
    ASSERT_EQ(dispose(3 + more, kDisposed), Code{});
    acknowledge();
  }
  EXPECT_FALSE(announced.has_ended(endpoint(1), true));
}

TEST_F(AnnouncedEndpointsTest, FilteredOnes_Stay) {
  ASSERT_EQ(announce(1), Code{});
  ASSERT_EQ(dispose(1, kFiltered), Code{});
  acknowledge();
  EXPECT_EQ(held(), cost(kUserData));
}

// The host acknowledges an announcement that it refuses, and keeps the former one.
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
      {inline_qos({{0x00, disposed}, {0x71, disposed}}), name_only(1)},  // PID_PAD
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

// The host keeps such an endpoint, so it must still count.
TEST_F(AnnouncedEndpointsTest, NumberThatTheHostPassesOver_EndsNothing) {
  ASSERT_EQ(announce(1), Code{});
  ASSERT_EQ(announce(2), Code{});
  acknowledge();
  for (const std::uint32_t number : {1, 2}) EXPECT_EQ(dispose_under(number, 2, kDisposed), Code{});
  EXPECT_EQ(held(), 2 * cost(kUserData));
}

TEST_F(AnnouncedEndpointsTest, NumberThatTheHostMayHaveSkipped_EndsNothing) {
  constexpr std::uint8_t kGap = 0x08, kHeartbeat = 0x07;
  const std::vector<Bytes> ways = {of_writer(kGap, kPublications, {0, 2, 0, 3, 0}),
                                   of_writer(kGap, kPublications, {0, 1, 0, 1, 32, 0x40000000}),
                                   of_writer(kHeartbeat, kPublications, {0, 3, 0, 9, 1})};
  for (const bool before : {true, false}) {
    for (const auto& way : ways) {
      next_number = 1;
      peers.peer.announced.~AnnouncedEndpoints();
      new (&peers.peer.announced) AnnouncedEndpoints();
      peers.peer.announced.set_account(account);
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

TEST_F(AnnouncedEndpointsTest, OtherNumbersSkipped_DoNotPreventTheEnd) {
  ASSERT_EQ(announce_under(1, 1), Code{});
  tell(of_writer(0x08, kPublications, {0, 2, 0, 5, 0}));
  ASSERT_EQ(dispose_under(5, 1, kDisposed), Code{});
  acknowledge(6);
  EXPECT_EQ(held(), 0u);
}

TEST_F(AnnouncedEndpointsTest, OneNumber_SaysOneThing) {
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

TEST_F(AnnouncedEndpointsTest, OneAnnouncement_SaysOneThing) {
  DataMessage message{.writer = kPublications,
                      .flags = 0x06,
                      .inline_qos = status_info({kDisposed, 0}),
                      .payload = announcement(1, 0)};
  EXPECT_EQ(code_of(check_builtin_source(message.octets(), kPeer, peers)),
            Code::builtin_source_unreadable);
  const auto one = announcement(1, 0), two = announcement(2, 0);
  message.inline_qos = status_info({});
  message.payload.assign(one.begin(), one.end() - 4);  // without the sentinel
  message.payload.insert(message.payload.end(), two.begin() + 4, two.end());
  EXPECT_EQ(code_of(check_builtin_source(message.octets(), kPeer, peers)),
            Code::builtin_source_unreadable);
}

// The announcements are repeated for a participant that is made later. They are new to it, and the
// host keeps them once more.
TEST_F(AnnouncedEndpointsTest, RepeatedForALaterParticipant_CountOnceThere) {
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
  peers.peer.announced.set_account(std::make_shared<AnnouncedOctets>());
  EXPECT_EQ(held_again(), 0u) << "it left the account";
}

// Endpoints that have ended must not count again in the account of new ones, because nothing would
// take them back.
TEST_F(AnnouncedEndpointsTest, RepeatedByAStranger_TakeNoRoomFromNewOnes) {
  constexpr std::uint32_t kMany = 2 * AnnouncedOctets::kMax / kUserData;
  for (std::uint32_t number = 1; number <= 2 * kMany; number += 2) {
    ASSERT_EQ(announce_under(number, number), Code{});
    ASSERT_EQ(dispose_under(number + 1, number, kDisposed), Code{});
    acknowledge(number + 2);
  }
  Code last{};
  for (std::uint32_t number = 1; number <= 2 * kMany; number += 2)
    last = announce_under(number, number);
  EXPECT_EQ(last, Code::builtin_source_unreadable) << "these are bounded, too";
  EXPECT_LE(held_again(), AnnouncedOctets::kMax);
  EXPECT_EQ(held(), 0u);
  EXPECT_EQ(announce_under(2 * kMany + 1, 1), Code{});
}

TEST_F(AnnouncedEndpointsTest, AnnouncementInFragments_CountsFromTheFirstOn) {
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

// Without the bound the host would hold any number of announcements for one endpoint, 128 of them
// with 23 MB each.
TEST_F(AnnouncedEndpointsTest, AnnouncementsInFragments_AreBoundedWhileOneBeforeThemIsMissing) {
  const auto large = announcement(1, 65'000);
  std::uint32_t number = 2;
  while (fragments(number, large) == Code{}) {
    peers.time += FragmentWalks::kKept;
    ASSERT_LE(++number, 2000u);
  }
  EXPECT_LE(held(), AnnouncedOctets::kMax);
  Bytes huge(FragmentWalks::kMaxOctets + 1);
  EXPECT_EQ(fragment(number + 1, huge, 1, 60'000), Code::builtin_source_unreadable);
}

TEST_F(AnnouncedEndpointsTest, ARefusedFirstFragment_DoesNotCount) {
  auto sample = announcement(1, kUserData);
  sample[1] = 9;  // is no parameter list
  EXPECT_EQ(fragment(1, sample, 1, 1344), Code::builtin_source_unreadable);
  EXPECT_EQ(held(), 0u);
}

TEST(SkippedNumbers, FewGaps_AreKnownExactly) {
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

TEST(SkippedNumbers, VeryManyGaps_AreAllCovered) {
  SkippedNumbers skipped;
  for (std::uint64_t number = 0; number < 1000; ++number) skipped.add(2 * number, 2 * number + 1);
  for (std::uint64_t number = 0; number < 1000; ++number) EXPECT_TRUE(skipped.contains(2 * number));
  EXPECT_FALSE(skipped.contains(1997));
}

TEST(AnnouncementAccounts, ParticipantsOfACertificate_ShareOneAccount) {
  const auto& topic = *discovery_topic_of(kPublications);
  AnnouncementAccounts accounts;
  constexpr auto kHalf = AnnouncedOctets::kMax / 2;
  const auto announces = [&](AnnouncedEndpoints& endpoints, std::uint64_t number,
                             std::size_t octets) {
    return endpoints
        .note(topic, {number, Announcement::Kind::announces, endpoint(1),
                      octets - AnnouncedOctets::kOfEach})
        .has_value();
  };
  AnnouncedEndpoints first, other;
  first.set_account(accounts.of(1));
  other.set_account(accounts.of(2));
  {
    AnnouncedEndpoints second;
    second.set_account(accounts.of(1));
    EXPECT_TRUE(announces(first, 1, kHalf));
    EXPECT_FALSE(announces(second, 1, kHalf + 1));
    EXPECT_TRUE(announces(other, 1, kHalf));
    EXPECT_TRUE(announces(second, 1, kHalf));
    EXPECT_FALSE(announces(first, 2, kHalf));
  }
  EXPECT_TRUE(announces(first, 2, kHalf)) << "the second has left";
}

}  // namespace
}  // namespace ddssec::cryptography
