// CONTENT_FILTER_INFO and the status of filtered samples, as they are sent.
#include "wire/content_filter_info.hpp"

#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/data.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST(ContentFilterInfoTest, EachSignature_HasABit) {
  std::vector<FilterResult> results(33);
  for (std::size_t i = 0; i < results.size(); ++i) {
    results[i].signature.fill(static_cast<std::uint8_t>(i));
    results[i].passed = i == 0 || i == 31 || i == 32;
  }
  std::array<std::uint8_t, 1024> buffer{};
  SpanWriter out(buffer, Endian::big);
  write_content_filter_info(out, {results});
  ASSERT_EQ(out.size(), 4 + 4 + 8 + 4 + 33 * 16u);
  const Bytes head{0x00, 0x55, 0x02, 0x20, 0, 0, 0, 2, 0x80, 0, 0, 1, 0x80, 0, 0, 0, 0, 0, 0, 33};
  EXPECT_EQ(to_bytes(out.view().first(head.size())), head);
  EXPECT_EQ(out.view()[head.size() + 16], 1);
}

TEST(ContentFilterInfoTest, FilterInfo_IsSteppedOverByReaders) {
  const FilterResult result{{7}, true};
  const auto octets = written(Data{.reader = kReader,
                                   .writer = kWriter,
                                   .inline_qos = {.filters = {{&result, 1}}},
                                   .kind = PayloadKind::data,
                                   .payload = as_bytes("data")});
  const auto data = read_data(view_of(octets));
  ASSERT_TRUE(data);
  EXPECT_TRUE(data->inline_qos.filters.list.empty());
  EXPECT_EQ(as_text(data->payload), "data");
}

TEST(FilteredStatusTest, FilteredFlag_IsRead) {
  const auto octets = written(
      Data{.reader = kReader, .writer = kWriter, .inline_qos = {.status = {.filtered = true}}});
  EXPECT_TRUE(read_data(view_of(octets))->inline_qos.status.filtered);
}

}  // namespace
}  // namespace ddssec::rtps
