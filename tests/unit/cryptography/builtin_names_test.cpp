// Announcements that would cost Cyclone's core more time than honest ones.
#include "plugins/cryptography/builtin_names.hpp"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography {
namespace {

using namespace testing;

constexpr EntityId kPublications{{0xff, 0, 3, 0xc2}};
constexpr std::uint16_t kPartition = 0x29, kEndpointGuid = 0x5a, kSentinel = 1;
constexpr std::uint16_t kLocators[] = {0x2f, 0x30, 0x31, 0x32, 0x33, 0x48};
// Returns the largest number of locators of one kind.
constexpr std::size_t max_of(std::uint16_t id) {
  const bool is_multicast = id == 0x30 || id == 0x33 || id == 0x48;
  return is_multicast ? ParameterWalk::kMaxMulticastLocators : ParameterWalk::kMaxLocators;
}

using Names = std::vector<std::string>;

// A parameter list of one byte order.
struct List {
  explicit List(bool little = true)
      : is_little(little), octets{0, static_cast<std::uint8_t>(little ? 3 : 2), 0, 0} {}
  void add(std::uint16_t id, const Bytes& value) {
    append(octets, id, 2, is_little);
    append(octets, value.size(), 2, is_little);
    append(octets, value);
  }
  void add(const Names& partitions) { add(kPartition, sequence(partitions)); }
  Bytes sequence(const Names& names) const {
    Bytes out;
    append(out, names.size(), 4, is_little);
    for (const auto& name : names) {
      append(out, name.size() + 1, 4, is_little);
      append(out, as_bytes(name));
      out.resize((out.size() + 1 + 3) / 4 * 4);
    }
    return out;
  }
  Bytes ended() const {
    auto list = *this;
    auto guid = to_bytes(kPeer.view());
    guid.resize(16);
    list.add(kEndpointGuid, guid);
    list.add(kSentinel, {});
    return list.octets;
  }
  bool is_little;
  Bytes octets;
};

// Reads the list in pieces of that size.
Status read(const List& list, std::size_t piece = 100'000) {
  const auto& topic = *discovery_topic_of(kPublications);
  ParameterWalk walk;
  const auto octets = list.ended();
  for (auto rest = BytesView(octets); !rest.empty();) {
    const auto part = rest.first(std::min(piece, rest.size()));
    DDSSEC_RETURN_IF_ERROR(walk.read(topic, kPeer, part));
    rest = rest.subspan(part.size());
  }
  return walk.check_end(topic);
}
Status read(const Names& partitions, bool little = true, std::size_t piece = 100'000) {
  List list(little);
  list.add(partitions);
  return read(list, piece);
}

constexpr std::size_t kPieces[] = {1, 3, 4, 7, 16, 100, 1344, 100'000};

TEST(CostlyPartitions, PartitionsThatPoliciesUse_Pass) {
  const Names used[] = {{},
                        {""},
                        {"*"},
                        {"a*"},
                        {"*/b/*"},
                        {"*/hall-2/*/telemetry"},
                        {"*a*b*"},
                        {"a", "bc", "def", "ghij", "", "?", "a?b", "*"},
                        {"**", "*?*?*?", "a**b", "???????????"},
                        Names(256, std::string(100, 'a')),
                        Names(60, std::string(1024, 'a')),
                        Names(256, "telemetry/*"),
                        Names(32, "*a*b*")};
  for (const auto& names : used)
    for (const bool little : {true, false})
      for (const auto piece : kPieces)
        EXPECT_EQ(code_of(read(names, little, piece)), Code{}) << names.size() << ' ' << piece;
}

TEST(CostlyPartitions, ExpressionsWithManyStars_AreRefused) {
  for (const auto* const expression :
       {"*a*b*c", "a*b*c*d", "*0*0*0*0*0*0*0*0*0*0*0*0*x", "*a*?*b*c", "**a**b**c", "?*?a*?b*?c"})
    for (const bool little : {true, false})
      for (const auto piece : kPieces)
        for (const auto& names : {Names{expression}, Names{"a", "*", expression, "b"}})
          EXPECT_EQ(code_of(read(names, little, piece)), Code::builtin_source_unreadable)
              << expression << ' ' << piece;
  EXPECT_EQ(code_of(read(Names(65, "*a"))), Code::builtin_source_unreadable);
  EXPECT_EQ(code_of(read(Names(64, "*a"))), Code{});
}

TEST(CostlyPartitions, RefusalSentence_NamesTheExpression) {
  const auto status = read(Names{"*cost*ly*name"});
  ASSERT_FALSE(status);
  const auto sentence = status.error().to_sentence();
  EXPECT_NE(sentence.find("\"*cost*ly*n"), sentence.npos) << sentence;
  EXPECT_NE(sentence.find("more than 2 '*'"), sentence.npos) << sentence;
}

TEST(CostlyPartitions, ManyOrLongOnes_AreRefused) {
  EXPECT_EQ(code_of(read(Names(257, "a"))), Code::builtin_source_unreadable);
  EXPECT_EQ(code_of(read(Names{std::string(1025, 'a')})), Code::builtin_source_unreadable);
  List twice;
  twice.add(Names{"a"});
  twice.add(Names{"b"});
  EXPECT_EQ(code_of(read(twice)), Code::builtin_source_unreadable);
}

TEST(CostlyPartitions, LyingLengths_AreRefused) {
  const List order;
  const auto whole = order.sequence({"abc", "*", "defgh"});
  for (std::size_t size = 0; size < whole.size(); size += 4)
    for (const auto piece : kPieces) {
      List list;
      list.add(kPartition, Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
      EXPECT_EQ(code_of(read(list, piece)), Code::builtin_source_unreadable) << size;
    }
  for (const std::uint8_t length : {0, 200}) {
    auto lie = whole;
    lie[4] = length;
    List list;
    list.add(kPartition, lie);
    EXPECT_EQ(code_of(read(list)), Code::builtin_source_unreadable) << length;
  }
  auto padded = whole;
  padded.resize(padded.size() + 8);
  List list;
  list.add(kPartition, padded);
  EXPECT_EQ(code_of(read(list)), Code{});
}

// Counts the steps of a matcher that tries all places for each run of stars, as that of Cyclone DDS
// does.
std::size_t steps(const char* expression, const char* name, bool& fits) {
  std::size_t count = 1;
  for (; *expression != '\0' && *expression != '*'; ++expression, ++name, ++count)
    if (*name == '\0' || (*expression != '?' && *expression != *name)) return fits = false, count;
  if (*expression == '\0') return fits = *name == '\0', count;
  for (; *expression == '*' || *expression == '?'; ++expression)
    if (*expression == '?' && *name++ == '\0') return fits = false, count;
  for (; *name != '\0'; ++name, ++count) {
    if (*name != *expression) continue;
    count += steps(expression + 1, name + 1, fits);
    if (fits) return count;
  }
  fits = *expression == '\0';
  return count;
}

// The costliest expressions that pass are matched against names of one repeated character. Without
// the limit, one expression could cost hours.
TEST(CostlyPartitions, WhatPasses_IsCheapToAMatcherThatTriesAll) {
  bool fits = false;
  const std::string name(64, '0');
  std::size_t worst = 0;
  for (int middle = 0; middle < 20; ++middle)
    for (int last = 0; last < 20; ++last)
      for (const auto* const end : {"x", "x*", "*"}) {
        const auto expression = "*0" + std::string(static_cast<std::size_t>(middle), '0') + "*" +
                                std::string(static_cast<std::size_t>(last), '0') + end;
        if (!read(Names(32, expression))) continue;
        worst = std::max(worst, 32 * steps(expression.c_str(), name.c_str(), fits));
      }
  EXPECT_GT(worst, 10'000u);
  EXPECT_LT(worst, 1'500'000u) << "some milliseconds";
  EXPECT_GT(steps("*0*0*0*0*0*x", name.c_str(), fits), worst);
}

TEST(CostlyLocators, SixteenUnicastAndFourMulticastOfEachKind_Pass) {
  List list;
  for (const auto id : kLocators)
    for (std::size_t i = 0; i < max_of(id); ++i) list.add(id, Bytes(24, 1));
  for (const auto piece : kPieces) EXPECT_EQ(code_of(read(list, piece)), Code{}) << piece;
  for (const auto id : kLocators) {
    auto more = list;
    more.add(id, Bytes(24, 1));
    for (const auto piece : kPieces)
      EXPECT_EQ(code_of(read(more, piece)), Code::builtin_source_unreadable) << id;
  }
}

TEST(CostlyLocators, LocatorsBeyondFour_CountAsFourKibibytesEach) {
  const auto cost = [](std::size_t each) {
    List list;
    for (const auto id : kLocators)
      for (std::size_t i = 0; i < std::min(each, max_of(id)); ++i) list.add(id, Bytes(24, 1));
    const auto octets = list.ended();
    ParameterWalk walk;
    EXPECT_TRUE(walk.read(*discovery_topic_of(kPublications), kPeer, octets));
    return walk.cost(1000);
  };
  EXPECT_EQ(cost(0), 1000u);
  EXPECT_EQ(cost(1), 1000u + 2 * 4096);
  EXPECT_EQ(cost(16), 1000u + (3 * 16 + 3 * 4 - 4) * 4096);
}

// The two ids are those of properties, and of the subscription keys of Cyclone DDS.
TEST(CostlyProperties, EachOctet_CountsSixTimes) {
  for (const int id : {0x59, 0x800f}) {
    List list;
    list.add(id, Bytes(160));
    ParameterWalk walk;
    EXPECT_TRUE(walk.read(*discovery_topic_of(kPublications), kPeer, list.ended()));
    EXPECT_EQ(walk.cost(1000), 1000u + 5 * 160) << id;
  }
}

TEST(CostlyPartitions, EachName_Counts48Octets) {
  List list;
  list.add(Names(256, "ab"));
  ParameterWalk walk;
  EXPECT_TRUE(walk.read(*discovery_topic_of(kPublications), kPeer, list.ended()));
  EXPECT_EQ(walk.cost(1000), 1000u + 256 * 48);
}

// For such an address Cyclone DDS frees memory that it never wrote.
TEST(DeprecatedAddresses, ListsThatHoldThem_AreRefused) {
  for (const int id : {0x0b, 0x0c, 0x0d, 0x0e, 0x11, 0x45, 0x46})
    for (const bool little : {true, false})
      for (const auto piece : kPieces) {
        List list(little);
        list.add(static_cast<std::uint16_t>(id), Bytes(4, 127));
        EXPECT_EQ(code_of(read(list, piece)), Code::builtin_source_unreadable) << id;
      }
  for (const int id : {0x0a, 0x0f, 0x10, 0x12, 0x44, 0x47}) {
    List list;
    list.add(static_cast<std::uint16_t>(id), Bytes(4, 127));
    EXPECT_EQ(code_of(read(list)), Code{}) << id;
  }
}

TEST(CostlyLocators, RefusalSentence_NamesTheirKind) {
  List list;
  for (int i = 0; i < 1000; ++i) list.add(0x2f, Bytes(24, 1));
  const auto status = read(list);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().to_sentence().find("more than 16 PID_UNICAST_LOCATOR"),
            std::string::npos)
      << status.error().to_sentence();
}

TEST(ClosedDiscovery, WritersOfItsTopics_AreIncludedAndNoOthers) {
  constexpr EntityId kClear{{0x00, 0x00, 0x03, 0xc2}}, kSecure{{0xff, 0x00, 0x04, 0xc2}};
  constexpr EntityId kSecureParticipants{{0xff, 0x01, 0x01, 0xc2}};
  constexpr ClosedDiscovery kSecureTopics{.secure_topics = true},
      kClearTopics{.clear_topics = true};
  EXPECT_TRUE(kSecureTopics.includes(kSecure));
  EXPECT_TRUE(kSecureTopics.includes(kSecureParticipants));
  EXPECT_FALSE(kSecureTopics.includes(kClear));
  EXPECT_TRUE(kClearTopics.includes(kClear));
  EXPECT_FALSE(kClearTopics.includes(kSecure));
  // Participants announce themselves in the clear. Liveliness and application topics are checked
  // elsewhere.
  constexpr ClosedDiscovery kAll{.secure_topics = true, .clear_topics = true};
  for (const EntityId open :
       {EntityId{{0x00, 0x01, 0x00, 0xc2}}, EntityId{{0xff, 0x02, 0x00, 0xc2}},
        EntityId{{0x00, 0x00, 0x01, 0x02}}})
    EXPECT_FALSE(kAll.includes(open)) << open.to_string();
}

}  // namespace
}  // namespace ddssec::cryptography
