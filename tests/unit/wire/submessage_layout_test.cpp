// The positions of entity ids are those at which the writers of submessages put them.
#include "wire/submessage_layout.hpp"

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

using testing::kReader;
using testing::kWriter;
using testing::written;

// Expects that the octets of a submessage without payload have both ids where their layout says.
void expect_layout(const Bytes& octets, bool is_of_reader) {
  const auto layout = layout_of(SubmessageId{octets.at(0)});
  ASSERT_TRUE(layout) << int{octets[0]};
  EXPECT_EQ(octets.size(), layout->min_size) << int{octets[0]};
  EXPECT_EQ(EntityId::from(BytesView(octets).subspan(layout->reader_at)), kReader);
  EXPECT_EQ(EntityId::from(BytesView(octets).subspan(layout->writer_at)), kWriter);
  EXPECT_EQ(layout->is_of_reader, is_of_reader);
  EXPECT_EQ(EntityId::from(BytesView(octets).subspan(layout->sender_at())),
            is_of_reader ? kReader : kWriter);
}

TEST(SubmessageLayout, EachSubmessageOfAWriter_HasItsIdsThere) {
  for (const auto endian : {Endian::little, Endian::big}) {
    expect_layout(written(Data{.reader = kReader, .writer = kWriter}, endian), false);
    expect_layout(
        written(DataFrag{.reader = kReader, .writer = kWriter, .fragment_size = 8}, endian), false);
    expect_layout(written(Gap{kReader, kWriter}, endian), false);
    expect_layout(written(Heartbeat{kReader, kWriter, {1}, {}}, endian), false);
    expect_layout(written(HeartbeatFrag{kReader, kWriter}, endian), false);
  }
}

TEST(SubmessageLayout, EachSubmessageOfAReader_HasItsIdsThere) {
  for (const auto endian : {Endian::little, Endian::big}) {
    expect_layout(written(AckNack{kReader, kWriter, {}}, endian), true);
    expect_layout(written(NackFrag{kReader, kWriter}, endian), true);
  }
}

TEST(SubmessageLayout, OtherSubmessages_HaveNone) {
  for (const auto id :
       {SubmessageId::header_extension, SubmessageId::pad, SubmessageId::info_timestamp,
        SubmessageId::info_source, SubmessageId::info_destination, SubmessageId::secure_prefix,
        SubmessageId::secure_rtps_prefix, SubmessageId{0x80}})
    EXPECT_FALSE(layout_of(id)) << static_cast<int>(id);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
