// The change that a DATA or DATA_FRAG carries.
#include "rtps/reliability/received_change.hpp"

#include <gtest/gtest.h>

#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using testing::kReader;
using testing::kWriter;

const auto kFrom = GuidPrefix::from(Bytes(12, 7));

TEST(ReceivedChange, Data_HasItsWriterNumberTimeAndPayload) {
  const Bytes octets{0, 1, 0, 0, 5};
  const Data data{kReader, kWriter, {9}, {}, PayloadKind::data, octets};
  const auto change = received_change(kFrom, data, Time{{3, 0}}, Payload::copy_of(octets));
  EXPECT_EQ(change.writer, (Guid{kFrom, kWriter}));
  EXPECT_EQ(change.sequence_number, SequenceNumber{9});
  EXPECT_EQ(change.source_time, (Time{{3, 0}}));
  EXPECT_EQ(to_bytes(change.payload.view()), octets);
}

TEST(ReceivedChange, DataFrag_HasRoomForTheWholeSample) {
  DataFrag frag;
  frag.writer = kWriter;
  frag.sequence_number = {9};
  frag.sample_size = 1000;
  const auto change = received_change(kFrom, frag, std::nullopt);
  EXPECT_EQ(change.sequence_number, SequenceNumber{9});
  EXPECT_EQ(change.payload.view().size(), 1000u);
}

}  // namespace
}  // namespace ddssec::rtps
