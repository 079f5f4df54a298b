// The form of filters in discovery and in samples (RTPS 2.5, 9.6.4.1).
#include "rtps/discovery/content_filter_property.hpp"

#include "base/hash.hpp"
#include "rtps/discovery/endpoint_data.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

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

TEST(ContentFilterPropertyTest, Filter_TravelsWithTheReader) {
  const auto data = subscription(property());
  const auto read = read_subscription_data(payload_of(data));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->content_filter, property());
  EXPECT_EQ(read_subscription_data(payload_of(subscription({})))->content_filter, std::nullopt);
}

TEST(ContentFilterPropertyTest, TheLongest_Fits) {
  auto longest = property();
  longest.filter.expression = std::string(Filter::kMaxExpression, 'x');
  longest.filter.parameters.assign(Filter::kMaxParameters, std::string(Filter::kMaxParameter, '1'));
  EXPECT_EQ(read_subscription_data(payload_of(subscription(longest)))->content_filter, longest);
}

// A reader that announces such a filter applies it itself, so this is no reason not to match.
TEST(ContentFilterPropertyTest, WhatIsTooLongOrEmpty_IsNone) {
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

TEST(ContentFilterPropertyTest, PropertyCutAnywhere_IsRefusedOrNone) {
  const auto whole = payload_of(subscription(property()));
  std::array<std::uint8_t, 512> buffer{};
  SpanWriter out(buffer);
  write_content_filter_property(out, property());
  // The last octet is padding.
  for (std::size_t size = 4; size + 1 < out.size(); ++size) {
    Reader reader(out.view().subspan(4, size - 4), Endian::little);
    EXPECT_FALSE(read_content_filter_property(reader)) << size;
  }
}

// The input is all strings with their NULs, in their order, without lengths between them.
TEST(ContentFilterPropertyTest, TheSignature_IsTheMd5OfItsStrings) {
  constexpr std::string_view all("Few\0Square\0DDSSQL\0x < %0\0005\0'BLUE'\0", 34);
  EXPECT_EQ(signature_of(property()), md5(as_bytes(all)));
  auto other = property();
  other.filter.parameters[0] = "6";
  EXPECT_NE(signature_of(property()), signature_of(other));
}

}  // namespace
}  // namespace ddssec::rtps
