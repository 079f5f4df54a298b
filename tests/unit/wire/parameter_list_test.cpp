// Parameter lists are walked to their end, or refused.
#include "wire/parameter_list.hpp"

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/parameters.hpp"
#include "wire/numbers.hpp"

namespace ddssec::rtps::parameters {
namespace {

using namespace std::chrono_literals;
using testing::code_of;

const Bytes kSentinel = {0, 1, 0, 0};

TEST(ParameterList, SentinelAndPadding_EndAndDoNotEndTheWalk) {
  const auto octets = list({{0, 0, 0, 4, 9, 9, 9, 9}, {0, 5, 0, 0}, kSentinel, {1, 2, 3}});
  ParameterReader reader(octets, Endian::big);
  EXPECT_EQ((*reader.next())->id, 5);
  EXPECT_FALSE(*reader.next());
  EXPECT_FALSE(*reader.next());
  EXPECT_EQ(parameter_list_prefix(octets, Endian::big)->size(), octets.size() - 3);
}

TEST(ParameterList, PadIsAskedFor_IsReturnedLikeOthers) {
  const auto octets = list({{0, 0, 0, 4, 9, 9, 9, 9}, {0, 5, 0, 0}, kSentinel, {1, 2, 3}});
  ParameterReader reader(octets, Endian::big);
  const auto pad = *reader.next_or_pad();
  EXPECT_EQ(pad->id, pid::kPad);
  EXPECT_EQ(pad->value.size(), 4u);
  EXPECT_EQ((*reader.next_or_pad())->id, 5);
  EXPECT_FALSE(reader.at_end());
  EXPECT_FALSE(*reader.next_or_pad());
  EXPECT_TRUE(reader.at_end()) << "octets after the sentinel do not count";
}

TEST(ParameterList, NoSentinel_EndsWhereTheOctetsEnd) {
  const auto octets = list({{0, 5, 0, 4, 1, 2, 3, 4}});
  ParameterReader reader(octets, Endian::big);
  EXPECT_FALSE(reader.at_end());
  EXPECT_EQ((*reader.next_or_pad())->id, 5);
  EXPECT_TRUE(reader.at_end());
  EXPECT_EQ(code_of(reader.next_or_pad()), Code::truncated);
  EXPECT_TRUE(ParameterReader({}, Endian::big).at_end());
}

TEST(ParameterList, HeaderInEitherByteOrder_IsRead) {
  const Bytes big = {0, 5, 0, 8}, little = {5, 0, 8, 0};
  for (const auto& [octets, endian] : {std::pair(big, Endian::big), {little, Endian::little}}) {
    Reader reader(octets, endian);
    const auto header = read_parameter_header(reader);
    ASSERT_TRUE(header);
    EXPECT_EQ(header->id, 5);
    EXPECT_EQ(header->length, 8);
    EXPECT_FALSE(header->is_sentinel());
    for (std::size_t size = 0; size < octets.size(); ++size) {
      Reader cut(BytesView(octets).first(size), endian);
      EXPECT_EQ(code_of(read_parameter_header(cut)), Code::truncated) << size;
    }
  }
}

TEST(ParameterList, LengthOfTheSentinel_DoesNotCount) {
  for (std::uint8_t length : {0, 1, 7, 255}) {
    const Bytes octets = {0, 1, 0xff, length};
    Reader reader(octets);
    const auto header = read_parameter_header(reader);
    ASSERT_TRUE(header) << int{length};
    EXPECT_TRUE(header->is_sentinel());
  }
}

// Cyclone DDS issue 1555 was in the scan for the end of a list.
TEST(ParameterList, EveryTruncation_IsRefused) {
  const auto octets =
      list({{0, 5, 0, 4, 1, 2, 3, 4}, {0x40, 0, 0, 8, 1, 2, 3, 4, 5, 6, 7, 8}, kSentinel});
  for (std::size_t size = 0; size < octets.size(); ++size)
    EXPECT_EQ(code_of(parameter_list_prefix(BytesView(octets).first(size), Endian::big)),
              Code::truncated);
}

TEST(ParameterList, OddAndLyingLengths_AreRefused) {
  for (std::uint8_t length : {1, 2, 3, 5})
    EXPECT_EQ(code_of(parameter_list_prefix(
                  list({{0, 5, 0, length, 1, 2, 3, 4, 5, 6, 7, 8}, kSentinel}), Endian::big)),
              Code::rtps_parameter_invalid);
  EXPECT_EQ(code_of(parameter_list_prefix(list({{0, 5, 0xff, 0xfc, 1, 2, 3, 4}, kSentinel}),
                                          Endian::big)),
            Code::truncated);
}

}  // namespace
}  // namespace ddssec::rtps::parameters
