// What filters look like in discovery and in samples (RTPS 2.5, 9.6.4.1).
#include "base/hash.hpp"
#include "rtps/discovery/endpoint_data.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/data.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

ContentFilterProperty property() {
  return {.content_filtered_topic_name = "Few",
          .related_topic_name = "Square",
          .filter = {"x < %0", {"5", "'BLUE'"}}};
}

EndpointData subscription(std::optional<ContentFilterProperty> filter) {
  EndpointData data{.guid = {GuidPrefix{{1, 2, 3}}, kReader}};
  data.topic_name = "Square";
  data.type_name = "ShapeType";
  data.content_filter = std::move(filter);
  return data;
}

Bytes payload_of(const EndpointData& data) {
  Bytes buffer(128 << 10);
  SpanWriter out(buffer);
  write_payload(out, data);
  EXPECT_FALSE(out.overflowed());
  return to_bytes(out.view());
}

TEST(ContentFilterPropertyTest, TravelsWithTheReader) {
  const auto data = subscription(property());
  const auto read = read_subscription_data(payload_of(data));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->content_filter, property());
  EXPECT_EQ(read_subscription_data(payload_of(subscription({})))->content_filter, std::nullopt);
}

TEST(ContentFilterPropertyTest, TheLongestFits) {
  auto longest = property();
  longest.filter.expression = std::string(Filter::kMaxExpression, 'x');
  longest.filter.parameters.assign(Filter::kMaxParameters, std::string(Filter::kMaxParameter, '1'));
  EXPECT_EQ(read_subscription_data(payload_of(subscription(longest)))->content_filter, longest);
}

// Who announces it filters itself; it is no reason not to match.
TEST(ContentFilterPropertyTest, WhatIsTooLongOrEmptyIsNone) {
  const auto none = [](auto change) {
    auto changed = property();
    change(changed);
    const auto read = read_subscription_data(payload_of(subscription(changed)));
    return read && !read->content_filter;
  };
  EXPECT_FALSE(none([](auto&) {}));
  EXPECT_TRUE(none([](auto& p) { p.filter.expression.assign(Filter::kMaxExpression + 1, 'x'); }));
  EXPECT_TRUE(none([](auto& p) { p.filter.expression.clear(); }));
  EXPECT_TRUE(none([](auto& p) { p.filter_class_name.clear(); }));
  EXPECT_TRUE(none([](auto& p) { p.related_topic_name.clear(); }));
  EXPECT_TRUE(none([](auto& p) { p.content_filtered_topic_name.assign(257, 'x'); }));
  EXPECT_TRUE(none([](auto& p) { p.filter.parameters.assign(101, "1"); }));
  EXPECT_TRUE(none([](auto& p) { p.filter.parameters.assign(1, std::string(257, '1')); }));
}

TEST(ContentFilterPropertyTest, TruncatedIsRefusedOrNone) {
  const auto whole = payload_of(subscription(property()));
  std::array<std::uint8_t, 512> buffer{};
  SpanWriter out(buffer);
  write_content_filter_property(out, property());
  // the last octet is padding
  for (std::size_t size = 4; size + 1 < out.size(); ++size) {
    Reader reader(out.view().subspan(4, size - 4), Endian::little);
    EXPECT_FALSE(read_content_filter_property(reader)) << size;
  }
}

// All strings with their NULs, in their order; no length between them.
TEST(ContentFilterPropertyTest, TheSignatureIsTheMd5OfItsStrings) {
  constexpr std::string_view all("Few\0Square\0DDSSQL\0x < %0\0005\0'BLUE'\0", 34);
  EXPECT_EQ(signature_of(property()), md5(as_bytes(all)));
  auto other = property();
  other.filter.parameters[0] = "6";
  EXPECT_NE(signature_of(property()), signature_of(other));
}

TEST(ContentFilterInfoTest, HasABitForEachSignature) {
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

TEST(ContentFilterInfoTest, IsSteppedOverByReaders) {
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

TEST(FilteredStatusTest, IsRead) {
  const auto octets = written(
      Data{.reader = kReader, .writer = kWriter, .inline_qos = {.status = {.filtered = true}}});
  EXPECT_TRUE(read_data(view_of(octets))->inline_qos.status.filtered);
}

}  // namespace
}  // namespace ddssec::rtps
