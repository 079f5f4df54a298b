// The scope of a local endpoint, which one plugin passes to another through the host.
#include "plugins/cyclonedds/endpoint_scope.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "plugins/cyclonedds/token_translation.hpp"
#include "tests/support/expect_code.hpp"

namespace ddssec::cyclonedds {
namespace {

// Properties in the host's form.
struct Properties {
  ~Properties() { free_properties(value); }
  DDS_Security_PropertySeq value{};
};

TEST(EndpointScope, WrittenScope_ComesBackWhole) {
  const std::vector<std::string_view> partitions = {"", "room*"};
  const spi::PropertyList tags = {{"colour", "blue"}, {"", "empty name"}};
  Properties properties;
  ASSERT_OK(make_scope(~std::uint64_t{0}, {"Square", partitions, tags}, properties.value));
  EXPECT_TRUE(is_scope(properties.value));
  const auto scope = EndpointScope::from(properties.value);
  ASSERT_OK(scope);
  EXPECT_EQ(scope->access_control(), ~std::uint64_t{0});
  const auto request = scope->request();
  EXPECT_EQ(request.topic_name, "Square");
  EXPECT_TRUE(std::ranges::equal(request.partitions, partitions));
  EXPECT_TRUE(std::ranges::equal(request.data_tags, tags));
}

TEST(EndpointScope, TextWithANul_IsRefusedAndNothingIsMade) {
  Properties properties;
  const std::string_view topic("a\0b", 3);
  EXPECT_CODE(make_scope(1, {.topic_name = topic}, properties.value), text_holds_nul);
  EXPECT_FALSE(is_scope(properties.value));
  EXPECT_EQ(properties.value._length, 0u);
}

TEST(EndpointScope, OtherProperties_AreNoScopeAndAreLeftAlone) {
  Properties properties;
  EXPECT_FALSE(is_scope(properties.value));
  ASSERT_OK(copy_properties({{"org.ddssec.topic", "Square"}}, properties.value));
  EXPECT_FALSE(is_scope(properties.value));
  free_scope(properties.value);
  EXPECT_EQ(properties.value._length, 1u);
  Properties scope;
  ASSERT_OK(make_scope(1, {.topic_name = "Square"}, scope.value));
  free_scope(scope.value);
  EXPECT_EQ(scope.value._length, 0u);
}

TEST(EndpointScope, ScopeWithoutItsNumberOrTopic_IsMalformed) {
  const std::string number = "org.ddssec.access_control", topic = "org.ddssec.topic";
  for (const auto& bad :
       {spi::PropertyList{}, spi::PropertyList{{number, "1"}}, spi::PropertyList{{topic, "Square"}},
        spi::PropertyList{{number, ""}, {topic, "Square"}},
        spi::PropertyList{{number, "1x"}, {topic, "Square"}},
        spi::PropertyList{{number, "-1"}, {topic, "Square"}},
        spi::PropertyList{{number, "18446744073709551616"}, {topic, "Square"}}}) {
    Properties properties;
    ASSERT_OK(copy_properties(bad, properties.value));
    EXPECT_CODE(EndpointScope::from(properties.value), malformed);
  }
}

}  // namespace
}  // namespace ddssec::cyclonedds
