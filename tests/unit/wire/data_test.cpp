// DATA: its payload, and the fields before it.
#include "wire/data.hpp"

#include <gmock/gmock.h>

#include "tests/unit/rtps/wire_helpers.hpp"
#include "tests/unit/wire/submessages.hpp"

namespace ddssec::rtps::submessages {
namespace {

using testing::code_of;
using testing::kReader;
using testing::kWriter;
using testing::view_of;
using testing::written;

Data sample_data(BytesView payload) {
  Data data{kReader, kWriter, {77}, {}, PayloadKind::data, payload};
  data.inline_qos.key_hash = KeyHash{1, 2, 3};
  data.inline_qos.status.disposed = true;
  return data;
}

TEST(Data, Data_RoundTripsAndTruncationsAreRefused) {
  const Bytes payload = {0, 1, 0, 0, 9, 8, 7, 6};
  for (auto endian : {Endian::big, Endian::little}) {
    const auto octets = written(sample_data(payload), endian);
    const auto view = view_of(octets);
    const auto copy = read_data(view);
    ASSERT_TRUE(copy);
    EXPECT_EQ(copy->sequence_number.value, 77);
    EXPECT_EQ(copy->inline_qos, sample_data(payload).inline_qos);
    EXPECT_EQ(to_bytes(copy->payload), payload);
    // Only the payload has no length of its own.
    for (std::size_t size = 0; size < view.body.size() - payload.size(); ++size) {
      auto cut = view;
      cut.body = view.body.first(size);
      EXPECT_EQ(code_of(read_data(cut)), Code::truncated) << size;
    }
  }
}

TEST(Data, DataWithDataAndKeyAtOnce_IsRefused) {
  auto octets = written(sample_data(Bytes{0, 1, 0, 0}));
  octets[1] |= 0x08;
  EXPECT_EQ(code_of(read_data(view_of(octets))), Code::malformed);
}

TEST(Data, TheOffsetToTheInlineQos_StaysInside) {
  for (std::uint8_t offset : {0, 4, 15, 200, 255}) {
    auto octets = written(sample_data(Bytes{0, 1, 0, 0}));
    octets[6] = offset;
    EXPECT_EQ(code_of(read_data(view_of(octets))), Code::rtps_submessage_overrun) << int{offset};
  }
}

}  // namespace
}  // namespace ddssec::rtps::submessages
