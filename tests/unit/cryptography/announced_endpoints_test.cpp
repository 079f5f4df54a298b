#include "plugins/cryptography/announced_endpoints.hpp"

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

struct AnnouncedEndpointsTest : ::testing::Test {
  Code announce(std::uint32_t number, std::size_t user_data = kUserData,
                const EntityId& writer = kPublications) {
    const DataMessage message{.writer = writer, .payload = announcement(number, user_data)};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  Code dispose(std::uint32_t number, std::uint8_t status) {
    Bytes ends;
    append(ends, 0x71, 2, true);
    append(ends, 4, 2, true);
    append(ends, status, 4, false);
    append(ends, 1, 4, true);
    const DataMessage message{.writer = kPublications,
                              .flags = 0x06,
                              .inline_qos = ends,
                              .payload = announcement(number, 0)};
    return code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  /// Until one more is refused.
  std::uint32_t fill() {
    while (announce(next) == Code{}) ++next;
    return next;
  }
  OneOwner peers;
  std::uint32_t next = 1;
};

TEST_F(AnnouncedEndpointsTest, AreBoundedByWhatTheyHold) {
  const auto one = announcement(1, kUserData).size() + AnnouncedOctets::kOfEach;
  EXPECT_EQ(fill(), AnnouncedOctets::kMost / one + 1);
  EXPECT_EQ(announce(next), Code::builtin_source_unreadable);
  EXPECT_EQ(announce(1), Code{}) << "it has not become larger";
}

TEST_F(AnnouncedEndpointsTest, AreBoundedByTheirNumber) {
  for (; announce(next, 0) == Code{}; ++next)
    ASSERT_LE(next, AnnouncedOctets::kMost / AnnouncedOctets::kOfEach);
}

TEST_F(AnnouncedEndpointsTest, CountOnceByEachWriterWhateverTheyWereBefore) {
  for (int again = 0; again < 3000; ++again) {
    ASSERT_EQ(announce(1), Code{});
    ASSERT_EQ(announce(1, kUserData, kSubscriptions), Code{});
  }
}

TEST_F(AnnouncedEndpointsTest, ThatAreGoneMakeRoom) {
  fill();
  constexpr std::uint8_t kDisposed = 1, kUnregistered = 2;
  for (const auto status : {kDisposed, kUnregistered}) {
    EXPECT_EQ(dispose(status, status), Code{});
    EXPECT_EQ(announce(next++), Code{});
    EXPECT_EQ(announce(next), Code::builtin_source_unreadable);
  }
  constexpr std::uint8_t kFiltered = 4;
  EXPECT_EQ(dispose(5, kFiltered), Code{});  // smaller now
  EXPECT_EQ(announce(next++), Code{});
  EXPECT_EQ(announce(next), Code::builtin_source_unreadable);
}

TEST_F(AnnouncedEndpointsTest, InFragmentsCountAsWell) {
  fill();
  const auto sample = announcement(next, kUserData);
  constexpr std::uint16_t kSize = 1344;
  auto code = Code{};
  for (std::uint32_t first = 1; code == Code{} && (first - 1) * kSize < sample.size(); ++first) {
    const auto begin = (first - 1) * kSize;
    const auto end = std::min<std::size_t>(begin + kSize, sample.size());
    const DataMessage message{
        .writer = kPublications,
        .payload = Bytes(sample.begin() + begin, sample.begin() + static_cast<long>(end)),
        .fragment = Fragment{
            .first = first, .size = kSize, .whole = static_cast<std::uint32_t>(sample.size())}};
    code = code_of(check_builtin_source(message.octets(), kPeer, peers));
  }
  EXPECT_EQ(code, Code::builtin_source_unreadable);
}

TEST(AnnouncementAccounts, AreSharedByTheParticipantsOfACertificate) {
  const auto& topic = *builtin_topic_of(kPublications);
  AnnouncementAccounts accounts;
  constexpr auto kHalf = AnnouncedOctets::kMost / 2;
  AnnouncedEndpoints first, other;
  first.count_for(accounts.of(1));
  other.count_for(accounts.of(2));
  {
    AnnouncedEndpoints second;
    second.count_for(accounts.of(1));
    EXPECT_TRUE(first.announce(topic, endpoint(1), kHalf));
    EXPECT_FALSE(second.announce(topic, endpoint(1), kHalf));
    EXPECT_TRUE(other.announce(topic, endpoint(1), kHalf));
    EXPECT_TRUE(second.announce(topic, endpoint(1), kHalf / 2));
    EXPECT_FALSE(first.announce(topic, endpoint(2), kHalf / 2));
  }
  EXPECT_TRUE(first.announce(topic, endpoint(2), kHalf / 2)) << "the second has left";
}

}  // namespace
}  // namespace ddssec::cryptography
