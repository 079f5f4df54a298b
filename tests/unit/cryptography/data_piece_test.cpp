// What is read from DATA, DATA_FRAG, GAP, HEARTBEAT, ACKNACK and NACK_FRAG, and where reading ends.
#include "plugins/cryptography/data_piece.hpp"

#include <gtest/gtest.h>

#include "tests/support/code_of.hpp"
#include "tests/unit/cryptography/data_message.hpp"

namespace ddssec::cryptography::testing {
namespace {

TEST(DataPiece, Data_HasItsNumberAndItsWholePayload) {
  for (const bool little : {true, false}) {
    const DataMessage message{.little = little, .number = 7};
    const auto octets = message.octets();
    EXPECT_EQ(writer_of_data(octets), kTokenWriter) << little;
    EXPECT_EQ(reader_of_data(octets), kTokenReader) << little;
    const auto piece = read_data_piece(octets);
    ASSERT_TRUE(piece) << piece.error().to_sentence();
    EXPECT_EQ(piece->writer, kTokenWriter) << little;
    EXPECT_EQ(piece->number, 7u) << little;
    EXPECT_TRUE(piece->has_data) << little;
    EXPECT_FALSE(piece->is_fragment) << little;
    EXPECT_EQ(to_bytes(piece->payload), message.payload) << little;
  }
}

TEST(DataPiece, DataFrag_HasItsPlaceInTheSample) {
  const auto octets =
      DataMessage{.fragment = Fragment{.first = 2, .size = 60, .whole = 120}}.octets();
  const auto piece = read_data_piece(octets);
  ASSERT_TRUE(piece) << piece.error().to_sentence();
  EXPECT_TRUE(piece->is_fragment);
  EXPECT_FALSE(piece->begins_sample);
  EXPECT_EQ(piece->first_fragment, 2u);
  EXPECT_EQ(piece->fragment_size, 60u);
  EXPECT_EQ(piece->sample_size, 120u);
}

TEST(DataPiece, CutOffBeforeItsPayload_IsRefused) {
  const auto octets = DataMessage{.payload = {}}.octets();
  for (std::size_t size = 16; size < octets.size(); ++size)
    EXPECT_EQ(test::code_of(read_data_piece(BytesView(octets).first(size))), Code::truncated)
        << size;
}

TEST(DataPiece, OtherSubmessages_HaveNoWriterOfData) {
  auto octets = DataMessage().octets();
  octets[0] = submessage_id::kHeartbeat;
  EXPECT_EQ(writer_of_data(octets), std::nullopt);
  EXPECT_EQ(writer_of_data(BytesView(octets).first(3)), std::nullopt);
}

// Returns a little-endian submessage with the two entity ids, and then 32-bit words.
Bytes submessage(std::uint8_t id, std::initializer_list<std::uint32_t> words) {
  Bytes out = {id, kFlagLittleEndian, 0, 0};
  append(out, kTokenReader.view());
  append(out, kTokenWriter.view());
  for (const auto word : words) append(out, word, 4, true);
  out[2] = static_cast<std::uint8_t>(out.size() - 4);
  return out;
}

TEST(DataPiece, HeartbeatAndGap_NameTheNumbersThatAreSkipped) {
  using Ranges = std::vector<std::pair<std::uint64_t, std::uint64_t>>;
  const auto heartbeat = read_skipped(submessage(submessage_id::kHeartbeat, {0, 5, 0, 9, 1}));
  ASSERT_TRUE(heartbeat);
  EXPECT_EQ(heartbeat->writer, kTokenWriter);
  ASSERT_EQ(heartbeat->ranges.size(), 1u);
  EXPECT_EQ(heartbeat->ranges.front().second, 5u) << "all before the first";
  const auto gap = read_skipped(submessage(submessage_id::kGap, {0, 3, 0, 6, 0}));
  ASSERT_TRUE(gap);
  EXPECT_EQ(gap->ranges, (Ranges{{3, 6}}));
  EXPECT_FALSE(read_skipped(submessage(submessage_id::kAckNack, {0, 3, 0, 1})));
}

TEST(DataPiece, Acknack_SaysWhatItsReaderHas) {
  const auto acknowledged = read_acknowledgment(submessage(submessage_id::kAckNack, {0, 8, 0, 1}));
  ASSERT_TRUE(acknowledged);
  EXPECT_EQ(acknowledged->writer, kTokenWriter);
  EXPECT_EQ(acknowledged->next, 8u);
  EXPECT_FALSE(read_acknowledgment(submessage(submessage_id::kGap, {0, 3, 0, 6, 0})));
}

TEST(DataPiece, NackFrag_NamesTheMessageWhoseFragmentsAreMissing) {
  const auto request = submessage(submessage_id::kNackFrag, {1, 8, 1, 1, 0x80000000, 1});
  EXPECT_EQ(read_fragment_request(request), (std::uint64_t{1} << 32) + 8);
  for (std::size_t size = 4; size < 20; ++size)
    EXPECT_EQ(read_fragment_request(BytesView(request).first(size)), std::nullopt) << size;
  EXPECT_FALSE(read_fragment_request(submessage(submessage_id::kAckNack, {0, 8, 0, 1})));
}

TEST(DataPiece, PlainCdr_IsOneOrTwoInEitherByteOrder) {
  for (int encoding = 0; encoding < 256; ++encoding) {
    const Bytes payload = {0, static_cast<std::uint8_t>(encoding), 0, 0};
    const bool is_plain = encoding == 0 || encoding == 1 || encoding == 6 || encoding == 7;
    EXPECT_EQ(is_plain_cdr(payload), is_plain) << encoding;
  }
  EXPECT_FALSE(is_plain_cdr(Bytes{1, 1, 0, 0}));
  EXPECT_FALSE(is_plain_cdr(Bytes{0, 1, 0}));
  EXPECT_FALSE(is_plain_cdr({}));
}

}  // namespace
}  // namespace ddssec::cryptography::testing
