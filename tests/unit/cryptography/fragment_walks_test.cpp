// Announcements in fragments, sent by Cyclone DDS and by an attacker.
#include "plugins/cryptography/fragment_walks.hpp"

#include <map>
#include <random>
#include <set>

#include <gtest/gtest.h>

#include "plugins/cryptography/builtin_checks.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr std::uint16_t kUserData = 0x2c, kEndpointGuid = 0x5a, kSentinel = 1;
constexpr std::uint16_t kFragmentSize = 1344;  // Cyclone DDS
constexpr EntityId kPublications{{0xff, 0, 3, 0xc2}};
constexpr auto kMax = static_cast<std::uint32_t>(FragmentWalks::kMaxSamples);

void append_parameter(Bytes& out, std::uint16_t id, const Bytes& value, bool little = true) {
  append(out, id, 2, little);
  append(out, value.size(), 2, little);
  append(out, value);
}
Bytes guid_of(const GuidPrefix& prefix) {
  auto out = to_bytes(prefix.view());
  append(out, Bytes{0, 0, 1, 3});
  return out;
}
// Returns an announcement with user data before the key, the order of Cyclone DDS.
Bytes announcement(const GuidPrefix& of, std::size_t user_data, bool little = true) {
  Bytes out = {0, static_cast<std::uint8_t>(little ? 3 : 2), 0, 0};
  append_parameter(out, kUserData, Bytes(user_data, 0x50), little);
  append_parameter(out, kEndpointGuid, guid_of(of), little);
  append_parameter(out, kSentinel, {}, little);
  return out;
}

class FragmentWalksTest : public ::testing::Test {
 protected:
  // Passes the fragment of that number, counted from 1, of a sample.
  Code pass(const Bytes& sample, std::uint32_t fragment, std::uint32_t number = 1,
            std::uint16_t size = kFragmentSize) {
    const auto from = (fragment - 1) * std::size_t{size};
    const auto to = std::min(from + size, sample.size());
    DataMessage message{
        .writer = kPublications,
        .flags = 0,
        .number = number,
        .payload = Bytes(sample.begin() + static_cast<std::ptrdiff_t>(from),
                         sample.begin() + static_cast<std::ptrdiff_t>(to)),
        .fragment = Fragment{
            .first = fragment, .size = size, .whole = static_cast<std::uint32_t>(sample.size())}};
    return code_of(check_builtin_source(message.octets(), kPeer, walks_));
  }
  static std::uint32_t fragments(const Bytes& sample, std::uint16_t size = kFragmentSize) {
    return static_cast<std::uint32_t>((sample.size() + size - 1) / size);
  }
  // Passes all fragments in order. Returns the code that ended this.
  Code pass_all(const Bytes& sample, std::uint32_t number = 1, std::uint16_t size = kFragmentSize) {
    for (std::uint32_t one = 1; one <= fragments(sample, size); ++one)
      if (const auto code = pass(sample, one, number, size); code != Code{}) return code;
    return {};
  }
  // The host has all samples below that number.
  void acknowledge(std::uint32_t next) {
    walks_.peer.announced.acknowledged(*discovery_topic_of(kPublications), next);
  }
  OneOwner walks_;
};

TEST_F(FragmentWalksTest, HonestOnesOfAnySize_Pass) {
  std::uint32_t number = 0;
  for (const bool little : {true, false}) {
    // These sizes put the key at each place relative to the end of the first fragment.
    for (std::size_t size = 1300; size <= 1360; size += 4)
      EXPECT_EQ(pass_all(announcement(kPeer, size, little), ++number), Code{}) << size;
    for (const std::size_t size : {1400, 3000, 20'000, 65'000})
      EXPECT_EQ(pass_all(announcement(kPeer, size, little), ++number), Code{}) << size;
  }
  for (const std::uint16_t size : {5, 9, 16, 30, 100})
    EXPECT_EQ(pass_all(announcement(kPeer, 200), ++number, size), Code{}) << size;
}

TEST_F(FragmentWalksTest, AnotherName_IsRefusedWhereItsPrefixEnds) {
  std::uint32_t number = 0;
  for (std::size_t size = 1300; size <= 1360; size += 4)
    EXPECT_EQ(pass_all(announcement(kVictim, size), ++number), Code::builtin_source_mismatch)
        << size;
  EXPECT_EQ(pass_all(announcement(kVictim, 20'000), ++number), Code::builtin_source_mismatch);
  // The foreign key may also follow the sender's own.
  auto both = announcement(kPeer, 100);
  both.resize(both.size() - 4);
  append_parameter(both, kUserData, Bytes(3000, 0x50));
  append_parameter(both, kEndpointGuid, guid_of(kVictim));
  append_parameter(both, kSentinel, {});
  EXPECT_EQ(pass_all(both, ++number), Code::builtin_source_mismatch);
}

TEST_F(FragmentWalksTest, WhatEndsWithoutAName_IsRefused) {
  auto nothing = announcement(kPeer, 3000);
  nothing.resize(nothing.size() - 24);
  auto cut = nothing;
  append_parameter(nothing, kSentinel, {});
  EXPECT_EQ(pass_all(nothing, 1), Code::builtin_source_unreadable);
  EXPECT_EQ(pass_all(cut, 2), Code::builtin_source_unreadable);
  auto odd = announcement(kPeer, 3000);
  odd[6] += 1;
  EXPECT_EQ(pass_all(odd, 3), Code::builtin_source_unreadable);
}

TEST_F(FragmentWalksTest, OutOfOrder_ComesAgain) {
  const auto sample = announcement(kPeer, 5000);
  EXPECT_EQ(pass(sample, 2), Code::builtin_fragment_early);
  EXPECT_EQ(pass(sample, 1), Code{});
  EXPECT_EQ(pass(sample, 3), Code::builtin_fragment_early);
  EXPECT_EQ(pass(sample, 2), Code{});
  EXPECT_EQ(pass(sample, 3), Code{});
  EXPECT_EQ(pass(sample, 1), Code{}) << "it is what it was";
  EXPECT_EQ(pass(sample, 4), Code{});
  EXPECT_EQ(pass_all(sample), Code{}) << "for another reader";
}

// An attacker that could replace a fragment which the host has, or does not have yet, would make
// the host read another list.
TEST_F(FragmentWalksTest, FragmentThatPassed_IsNotReplaced) {
  const auto sample = announcement(kPeer, 3000);
  auto other = sample;
  other[8] ^= 1;
  EXPECT_EQ(pass(sample, 1), Code{});
  EXPECT_EQ(pass(other, 1), Code::builtin_source_unreadable);
  auto longer = announcement(kPeer, 3004);
  EXPECT_EQ(pass(longer, 2), Code::builtin_source_unreadable) << "of another size";
  EXPECT_EQ(pass(sample, 2, 1, 1340), Code::builtin_source_unreadable) << "cut otherwise";
  EXPECT_EQ(pass(sample, 2), Code{});
  EXPECT_EQ(pass(sample, 3), Code{});
  EXPECT_EQ(pass(other, 1), Code::builtin_source_unreadable) << "a whole one";
}

// In the first list the second fragment is user data. In the second list a name begins there.
TEST_F(FragmentWalksTest, TwoLists_AreNotSpliced) {
  const auto harmless = announcement(kPeer, 3000);
  auto lie = harmless;
  Bytes name;
  append_parameter(name, kEndpointGuid, guid_of(kVictim));
  std::ranges::copy(name, lie.begin() + kFragmentSize);
  // If it is read after the first fragment of `harmless`, or in `lie` alone, the name is user data.
  EXPECT_EQ(pass_all(lie, 1), Code{});
  auto opens = Bytes{0, 3, 0, 0};
  append_parameter(opens, kUserData, Bytes(kFragmentSize - 8, 0x50));
  append(opens, BytesView(lie).subspan(kFragmentSize));
  EXPECT_EQ(pass(opens, 1, 2), Code{});
  EXPECT_EQ(pass(lie, 1, 2), Code::builtin_source_unreadable);
  EXPECT_EQ(pass(lie, 2, 2), Code::builtin_source_mismatch);
}

TEST_F(FragmentWalksTest, ARefusedFragment_ChangesNothing) {
  const auto sample = announcement(kPeer, 3000);
  auto lie = sample;
  const auto at = lie.size() - 4 - 16;
  std::ranges::copy(kVictim.view(), lie.begin() + static_cast<std::ptrdiff_t>(at));
  EXPECT_EQ(pass(sample, 1), Code{});
  EXPECT_EQ(pass(sample, 2), Code{});
  EXPECT_EQ(pass(lie, 3), Code::builtin_source_mismatch);
  EXPECT_EQ(pass(sample, 3), Code{});
  EXPECT_EQ(pass_all(announcement(kPeer, 3000), 2), Code{}) << "later ones go on";
}

// Splicing is only possible because the host holds the second fragment of the first list. It drops
// samples by limits of its own, and joins the rest to whatever arrives later, however many samples
// passed in between.
TEST_F(FragmentWalksTest, WhatFollows_NeverSplicesASample) {
  const auto harmless = announcement(kPeer, 3000);
  auto other = harmless;
  other[8] ^= 1;
  const auto number = kMax + 100;
  ASSERT_EQ(pass_all(harmless, number), Code{});
  for (std::uint32_t one = 1; one <= 3 * kMax; ++one) {
    (void)pass_all(announcement(kPeer, 1400), number + one);
    acknowledge(number + one + 1);
    if (one % 50 == 0) walks_.time += FragmentWalks::kKept;
    if (one % 7 == 0) {
      ASSERT_NE(pass(other, 1, number), Code{}) << one;
    }
  }
  EXPECT_EQ(pass(other, 1, number), Code::builtin_fragment_early) << "it is forgotten";
  EXPECT_EQ(pass(harmless, 1, number), Code::builtin_fragment_early);
  EXPECT_EQ(pass(harmless, 2, number), Code::builtin_fragment_early);
}

TEST_F(FragmentWalksTest, SameFragment_ComesAgainAsOftenAsItIsAskedFor) {
  const auto sample = announcement(kPeer, 3000);
  for (std::uint32_t number = 1; number <= kMax; ++number)
    ASSERT_EQ(pass_all(sample, number), Code{});
  walks_.time += 100 * FragmentWalks::kKept;
  for (int turn = 0; turn < 2; ++turn)  // once more, as for another reader
    for (std::uint32_t number = 1; number <= kMax; ++number)
      ASSERT_EQ(pass_all(sample, number), Code{});
}

TEST_F(FragmentWalksTest, NewSamples_TakeThePlacesOfTheLowest) {
  const auto sample = announcement(kPeer, 20'000);
  for (std::uint32_t number = 1; number <= 2 * kMax; ++number) {
    walks_.time += std::chrono::milliseconds(100);
    ASSERT_EQ(pass_all(sample, number), Code{}) << number;
    acknowledge(number + 1);
  }
}

TEST_F(FragmentWalksTest, LowestOnes_StayForFiveSeconds) {
  const auto sample = announcement(kPeer, 3000);
  for (std::uint32_t number = 2; number < 2 + kMax; ++number)
    ASSERT_EQ(pass_all(sample, number), Code{});
  EXPECT_EQ(pass(sample, 1, 2 + kMax), Code::builtin_fragment_early);
  EXPECT_EQ(pass_all(sample, 1), Code{}) << "the host needs this one first, and there is room";
  acknowledge(2 + kMax);
  EXPECT_EQ(pass(sample, 1, 2 + kMax), Code::builtin_fragment_early);
  walks_.time += FragmentWalks::kKept;
  EXPECT_EQ(pass_all(sample, 2 + kMax), Code{});
  EXPECT_EQ(pass(sample, 1, 1), Code::builtin_fragment_early) << "forgotten, and refused for good";
  EXPECT_EQ(pass_all(sample, 1 + kMax), Code{}) << "known still";
}

// The lowest one must not be forgotten, because the host waits for it.
TEST_F(FragmentWalksTest, OneLostForLong_PassesStill) {
  const auto sample = announcement(kPeer, 3000);
  for (std::uint32_t number = 2; number < 2 + kMax; ++number)
    ASSERT_EQ(pass_all(sample, number), Code{});
  walks_.time += 10 * FragmentWalks::kKept;
  EXPECT_EQ(pass(sample, 1, 2 + kMax), Code::builtin_fragment_early);
  EXPECT_EQ(pass_all(sample, 1), Code{});
  acknowledge(2 + kMax);
  walks_.time += FragmentWalks::kKept;
  EXPECT_EQ(pass_all(sample, 2 + kMax), Code{});
}

TEST_F(FragmentWalksTest, UnfinishedOnes_AreBounded) {
  const auto sample = announcement(kPeer, 3000);
  constexpr auto kSpare = static_cast<std::uint32_t>(FragmentWalks::kSpareSamples);
  const auto above = 2 * kSpare;
  for (std::uint32_t number = above; number < above + kMax; ++number)
    ASSERT_EQ(pass(sample, 1, number), Code{});
  EXPECT_EQ(pass(sample, 1, above + kMax), Code::builtin_fragment_early);
  for (std::uint32_t number = 1; number <= kSpare; ++number)
    ASSERT_EQ(pass(sample, 1, number), Code{}) << "room for lower ones";
  EXPECT_EQ(pass(sample, 1, kSpare + 1), Code::builtin_fragment_early);
  EXPECT_EQ(pass_all(sample, above), Code{}) << "those that are known go on";
}

TEST_F(FragmentWalksTest, Fragments_AreBounded) {
  const auto sample = announcement(kPeer, 60'000);
  const auto most = static_cast<std::uint32_t>(FragmentWalks::kMaxFragments) / fragments(sample);
  for (std::uint32_t number = 1; number <= most; ++number)
    ASSERT_EQ(pass_all(sample, number), Code{});
  EXPECT_EQ(pass(sample, 1, most + 1), Code::builtin_fragment_early);
  walks_.time += FragmentWalks::kKept;
  acknowledge(most + 1);
  EXPECT_EQ(pass(sample, 1, most + 1), Code{});
}

// A GAP can let the host go on to the next sample.
TEST_F(FragmentWalksTest, AnUnfinishedOne_MakesRoomOnceTheHostGoesOn) {
  const auto sample = announcement(kPeer, 3000);
  for (std::uint32_t number = 1; number <= kMax; ++number)
    ASSERT_EQ(pass(sample, 1, number), Code{});
  EXPECT_EQ(pass(sample, 1, 1 + kMax), Code::builtin_fragment_early);
  walks_.time += FragmentWalks::kKept;
  EXPECT_EQ(pass(sample, 1, 1 + kMax), Code::builtin_fragment_early);
  acknowledge(2);
  EXPECT_EQ(pass_all(sample, 1 + kMax), Code{});
  EXPECT_EQ(pass(sample, 2, 1), Code::builtin_fragment_early) << "it was given up";
  EXPECT_EQ(pass(sample, 2, 2), Code{});
}

// One of five fragments is lost. Lost fragments are sent again, the lowest first.
TEST_F(FragmentWalksTest, HonestOnesUnderLoss_AllPass) {
  const auto sample = announcement(kPeer, 5000);
  constexpr std::uint32_t kSamples = 3000, kWindow = 256;
  std::minstd_rand random(7);
  std::set<std::uint32_t> missing;
  for (std::uint32_t number = 1; number <= kSamples; ++number) missing.insert(number);
  std::map<std::uint32_t, std::uint32_t> had;  // by number: fragments that arrived in order
  for (int round = 0; !missing.empty(); ++round) {
    ASSERT_LT(round, 1000) << *missing.begin() << " never passes";
    walks_.time += std::chrono::milliseconds(100);
    acknowledge(*missing.begin());
    const auto window =
        std::vector(missing.begin(), missing.upper_bound(*missing.begin() + kWindow - 1));
    for (const auto number : window) {
      for (auto one = had[number] + 1; one <= fragments(sample); ++one) {
        if (random() % 5 == 0) continue;
        const auto code = pass(sample, one, number);
        if (code == Code{}) had[number] = one;
        if (code != Code{}) {
          ASSERT_EQ(code, Code::builtin_fragment_early);
        }
      }
      if (had[number] == fragments(sample)) missing.erase(number);
    }
  }
}

TEST_F(FragmentWalksTest, TooLargeOnes_AreRefused) {
  Bytes sample = {0, 3, 0, 0};
  while (sample.size() <= FragmentWalks::kMaxOfSample * kFragmentSize)
    append_parameter(sample, kUserData, Bytes(60'000, 0x50));
  EXPECT_EQ(pass(sample, 1), Code::builtin_source_unreadable);
  EXPECT_EQ(pass_all(announcement(kPeer, 3000), 2), Code{});
}

TEST_F(FragmentWalksTest, LyingLengths_AreRefused) {
  DataMessage message{.writer = kPublications,
                      .flags = 0,
                      .payload = Bytes(100, 0),
                      .fragment = Fragment{.size = 0, .whole = 200}};
  const auto code = [&] { return code_of(check_builtin_source(message.octets(), kPeer, walks_)); };
  EXPECT_EQ(code(), Code::builtin_source_unreadable);
  message.fragment->size = 104;  // the payload is shorter
  EXPECT_EQ(code(), Code::builtin_source_unreadable);
}

// In the clear within a protected message, an early fragment is hidden so that it comes again, and
// the rest passes.
TEST_F(FragmentWalksTest, EarlyOneInAMessage_IsHidden) {
  const auto sample = announcement(kPeer, 3000);
  const DataMessage second{
      .writer = kPublications,
      .flags = 0,
      .payload = Bytes(sample.begin() + kFragmentSize, sample.begin() + 2 * kFragmentSize),
      .fragment = Fragment{
          .first = 2, .size = kFragmentSize, .whole = static_cast<std::uint32_t>(sample.size())}};
  auto content = data_submessage(16);
  const auto at = content.size();
  append(content, second.octets());
  append(content, data_submessage(16));
  const auto part = part_of_sender(content, kPeer, walks_);
  EXPECT_EQ(part.size, content.size());
  EXPECT_FALSE(part.ended);
  EXPECT_EQ(part.hidden, std::vector{at});
}

}  // namespace
}  // namespace ddssec::cryptography
