// Partitions of announcements, read in pieces of any size.
#include "plugins/cryptography/partition_walk.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "plugins/cryptography/builtin_names.hpp"
#include "tests/unit/cryptography/data_message.hpp"

namespace ddssec::cryptography {
namespace {

using testing::append;

const DiscoveryTopic& topic() { return *discovery_topic_of(EntityId{{0xff, 0, 3, 0xc2}}); }

Bytes value_of(const std::vector<std::string>& names, bool is_little) {
  Bytes out;
  append(out, names.size(), 4, is_little);
  for (const auto& name : names) {
    append(out, name.size() + 1, 4, is_little);
    append(out, as_bytes(name));
    out.push_back(0);
    out.resize((out.size() + 3) / 4 * 4);
  }
  return out;
}

// Reads the value in pieces of `size` octets, and returns the first error.
Status walked(const Bytes& value, bool is_little = true, std::size_t size = 1000,
              PartitionWalk* end = nullptr) {
  PartitionWalk walk(static_cast<std::uint16_t>(value.size()), is_little);
  for (std::size_t at = 0; at < value.size(); at += size) {
    const auto piece = BytesView(value).subspan(at, std::min(size, value.size() - at));
    DDSSEC_RETURN_IF_ERROR(walk.read(topic(), piece));
  }
  if (end != nullptr) *end = walk;
  return {};
}
Code code(const Status& status) { return status ? Code{} : status.error().code(); }

TEST(PartitionWalk, NamesInBothByteOrdersAndPiecesOfEachSize_AreCounted) {
  for (const bool is_little : {true, false}) {
    const auto value = value_of({"", "a", "room*", "four"}, is_little);
    for (std::size_t size = 1; size <= value.size(); ++size) {
      PartitionWalk walk;
      EXPECT_EQ(code(walked(value, is_little, size, &walk)), Code{}) << size;
      EXPECT_EQ(walk.names(), 4u);
      EXPECT_EQ(walk.rest(), 0u);
    }
  }
  EXPECT_EQ(code(walked(value_of({}, true))), Code{});
}

TEST(PartitionWalk, EveryTruncation_IsRefused) {
  const auto value = value_of({"abc", "de"}, true);
  // The value is complete even without its padding.
  for (std::size_t size = 1; size < value.size() - 1; ++size) {
    const Bytes part(value.begin(), value.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_EQ(code(walked(part)), Code::builtin_source_unreadable) << size;
  }
}

TEST(PartitionWalk, LengthsThatLie_AreRefused) {
  auto value = value_of({"abc"}, true);
  for (const std::uint8_t lie : {0, 200}) {
    value[4] = lie;
    EXPECT_EQ(code(walked(value)), Code::builtin_source_unreadable) << int{lie};
  }
}

TEST(PartitionWalk, Bounds_AreThoseOfAccessControl) {
  const std::vector<std::string> most(PartitionWalk::kMaxNames, "a");
  EXPECT_EQ(code(walked(value_of(most, true))), Code{});
  auto more = most;
  more.push_back("a");
  EXPECT_EQ(code(walked(value_of(more, true))), Code::builtin_source_unreadable);
  const std::string longest(PartitionWalk::kMaxNameOctets, 'a');
  EXPECT_EQ(code(walked(value_of({longest}, true))), Code{});
  EXPECT_EQ(code(walked(value_of({longest + "a"}, true))), Code::builtin_source_unreadable);
}

TEST(PartitionWalk, Stars_CountIfSomethingFollows) {
  for (const char* const good : {"*a*b", "*a*b*", "**?*a", "*?*?*", "***", "a?b?c?d", "*a*b**?"})
    EXPECT_EQ(code(walked(value_of({good}, true))), Code{}) << good;
  for (const char* const bad : {"*a*b*c", "*a?*b?*c", "*a*a*a*a"}) {
    const auto refused = walked(value_of({bad}, true));
    ASSERT_EQ(code(refused), Code::builtin_source_unreadable) << bad;
    EXPECT_NE(refused.error().details().note.find("more than 2 '*'"), std::string::npos);
  }
}

TEST(PartitionWalk, StarsOfAllNames_AreBoundedTogether) {
  std::vector<std::string> names(PartitionWalk::kMaxStarsOfSample / 2, "*a*b");
  EXPECT_EQ(code(walked(value_of(names, true))), Code{});
  names.push_back("*a");
  EXPECT_EQ(code(walked(value_of(names, true))), Code::builtin_source_unreadable);
}

}  // namespace
}  // namespace ddssec::cryptography
