#include "rtps/participant/match_table.hpp"

#include <gtest/gtest.h>

namespace ddssec::rtps {
namespace {

GuidPrefix identity(std::uint8_t number) {
  GuidPrefix out;
  out.octets[0] = number;
  return out;
}

// Adds endpoints of the identity until there is no room, and returns their number.
std::size_t fill(MatchTable& table, std::uint8_t of, bool has_macs) {
  std::size_t count = 0;
  for (Guid guid{identity(of), {}}; table.has_room(identity(of), has_macs) && count < 5000;
       ++count) {
    guid.entity.octets[0] = static_cast<std::uint8_t>(count >> 8);
    guid.entity.octets[1] = static_cast<std::uint8_t>(count);
    table.add(guid, identity(of), true);
  }
  return count;
}

TEST(MatchTableTest, EndpointsWithoutMacs_HaveOneLimitForEachIdentity) {
  MatchTable table;
  for (std::uint8_t of = 1; of <= 4; ++of) EXPECT_EQ(fill(table, of, false), MatchTable::kMaxOfOne);
}

// Without this bound, three identities with 1024 readers each made the messages to all others too
// long.
TEST(MatchTableTest, EndpointsWithMacs_LeaveRoomForAnotherIdentity) {
  MatchTable table;
  EXPECT_EQ(fill(table, 1, true), MatchTable::kMaxWithMacs / 2);
  EXPECT_EQ(fill(table, 2, true), MatchTable::kMaxWithMacs / 4);
  EXPECT_GT(fill(table, 3, true), 100u);
  EXPECT_TRUE(table.has_room(identity(9), true));
}

TEST(MatchTableTest, LastOneThatAnyoneCanHaveAnnounced_IsReplaceable) {
  MatchTable table;
  const auto guid = [](std::uint8_t number) { return Guid{identity(1), {{0, 0, number, 7}}}; };
  table.add(guid(9), identity(1), true);
  EXPECT_EQ(table.replaceable(identity(1), false), std::nullopt);
  for (const int number : {3, 5, 4})
    table.add(guid(static_cast<std::uint8_t>(number)), identity(1), false);
  EXPECT_EQ(table.replaceable(identity(1), false), guid(4));
  EXPECT_EQ(table.replaceable(identity(2), false), std::nullopt);
  table.remove(guid(4));
  EXPECT_EQ(table.replaceable(identity(1), false), guid(5));
}

// The identity has more than its share since other identities came.
TEST(MatchTableTest, TableThatOneLessLeavesFull_HasNoneReplaceable) {
  MatchTable table;
  table.add({identity(1), {{1, 0, 0, 7}}}, identity(1), false);
  fill(table, 1, true);
  EXPECT_NE(table.replaceable(identity(1), true), std::nullopt);
  fill(table, 2, true);
  EXPECT_EQ(table.replaceable(identity(1), true), std::nullopt);
}

}  // namespace
}  // namespace ddssec::rtps
