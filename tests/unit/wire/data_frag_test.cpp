// DATA_FRAG: fragments must lie inside their sample.
#include "wire/data_frag.hpp"

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

DataFrag sample_frag(BytesView payload) {
  DataFrag frag{kReader, kWriter, {5}, {2}, 2, 8, 20, {}, false, payload};
  frag.inline_qos.key_hash = KeyHash{9};
  return frag;
}

TEST(DataFrag, DataFrag_RoundTripsAndTruncationsAreRefused) {
  const Bytes payload(12, 0xaa);  // all of fragment 2, and the last 4 octets in fragment 3
  for (auto endian : {Endian::big, Endian::little}) {
    const auto octets = written(sample_frag(payload), endian);
    const auto view = view_of(octets);
    const auto copy = read_data_frag(view);
    ASSERT_TRUE(copy);
    EXPECT_EQ(copy->total(), 3u);
    EXPECT_EQ(to_bytes(copy->payload), payload);
    EXPECT_EQ(copy->inline_qos, sample_frag(payload).inline_qos);
    for (std::size_t size = 0; size < view.body.size(); ++size) {
      auto cut = view;
      cut.body = view.body.first(size);
      EXPECT_EQ(code_of(read_data_frag(cut)), Code::truncated) << size;
    }
  }
}

// CVE-2023-50716, CVE-2025-62799, CVE-2026-22590, CVE-2025-65865.
TEST(DataFrag, Fragments_MustLieInsideTheirSample) {
  const Bytes payload(64, 0);
  auto lying = [&](auto&& change) {
    auto frag = sample_frag(payload);
    change(frag);
    return code_of(read_data_frag(view_of(written(frag))));
  };
  EXPECT_EQ(lying([](auto& f) { f.first = {0}; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.first = {4}; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.first = {0xffffffff}; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.count = 0; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.count = 3; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.fragment_size = 0; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.sample_size = 0; }), Code::rtps_number_invalid);
  EXPECT_EQ(lying([](auto& f) { f.fragment_size = 65535, f.sample_size = 0xffffffff; }),
            Code::truncated);
}

}  // namespace
}  // namespace ddssec::rtps::submessages
