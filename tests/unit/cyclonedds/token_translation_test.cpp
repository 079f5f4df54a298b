#include "plugins/cyclonedds/token_translation.hpp"

#include "tests/unit/cyclonedds/support.hpp"

namespace ddssec::cyclonedds {
namespace {

TEST(TokenTranslation, ThereAndBack_IsTheSame) {
  DDS_Security_DataHolder copy;
  ASSERT_TRUE(copy_token(sample_token(), copy));
  const auto back = token_from(&copy);
  ASSERT_TRUE(back);
  EXPECT_EQ(*back, sample_token());
  free_token(copy);
}

// The host frees each string and buffer separately, so each must be a block of its own. (Under the
// address sanitizer anything else fails here.)
TEST(TokenTranslation, EveryPart_IsItsOwnBlock) {
  DDS_Security_DataHolder copy;
  ASSERT_TRUE(copy_token(sample_token(), copy));
  std::free(copy.class_id);
  for (unsigned i = 0; i < copy.properties._length; ++i) {
    std::free(copy.properties._buffer[i].name);
    std::free(copy.properties._buffer[i].value);
  }
  std::free(copy.properties._buffer);
  for (unsigned i = 0; i < copy.binary_properties._length; ++i) {
    std::free(copy.binary_properties._buffer[i].name);
    std::free(copy.binary_properties._buffer[i].value._buffer);
  }
  std::free(copy.binary_properties._buffer);
}

TEST(TokenTranslation, NoOctets_MeansNoBufferAndNoLength) {
  DDS_Security_DataHolder copy;
  ASSERT_TRUE(copy_token(sample_token(), copy));
  const auto& empty = copy.binary_properties._buffer[1].value;
  EXPECT_EQ(empty._length, 0u);
  EXPECT_EQ(empty._buffer, nullptr);
  free_token(copy);

  ASSERT_TRUE(copy_token({.class_id = "only"}, copy));
  EXPECT_EQ(copy.properties._buffer, nullptr);
  EXPECT_EQ(copy.binary_properties._length, 0u);
  free_token(copy);
}

TEST(TokenTranslation, FreeingTwice_IsHarmless) {
  DDS_Security_DataHolder copy;
  ASSERT_TRUE(copy_token(sample_token(), copy));
  free_token(copy);
  EXPECT_TRUE(is_nil(&copy));
  free_token(copy);

  DDS_Security_DataHolderSeq sequence;
  ASSERT_TRUE(copy_tokens(std::vector{sample_token(), sample_token()}, sequence));
  EXPECT_EQ(sequence._length, 2u);
  free_tokens(sequence);
  free_tokens(sequence);
  EXPECT_EQ(sequence._length, 0u);
}

TEST(TokenTranslation, NulInText_IsRefusedAndLeavesNothing) {
  auto token = sample_token();
  token.properties[1].value = std::string("a\0b", 3);
  DDS_Security_DataHolder copy;
  const auto status = copy_token(token, copy);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code(), Code::text_holds_nul);
  EXPECT_TRUE(is_nil(&copy));
}

TEST(TokenTranslation, NilAndBrokenTokens_AreRefused) {
  EXPECT_EQ(token_from(nullptr).error().code(), Code::null_argument);
  DDS_Security_DataHolder nil{};
  EXPECT_EQ(token_from(&nil).error().code(), Code::null_argument);

  std::string class_id = "class";
  DDS_Security_DataHolder holder{};
  holder.class_id = class_id.data();
  holder.properties._length = 1;  // has no buffer
  EXPECT_EQ(token_from(&holder).error().code(), Code::null_argument);

  DDS_Security_Property_t property{};  // has no name and no value
  holder.properties._buffer = &property;
  EXPECT_EQ(token_from(&holder).error().code(), Code::null_argument);

  holder.properties = {};
  std::string name = "name";
  DDS_Security_BinaryProperty_t binary{name.data(), {4, 4, nullptr}, 1};
  holder.binary_properties = {1, 1, &binary};
  EXPECT_EQ(token_from(&holder).error().code(), Code::null_argument);
  binary.name = nullptr;
  EXPECT_EQ(token_from(&holder).error().code(), Code::null_argument);
}

TEST(TokenTranslation, TooManyPropertiesOrTokens_AreRefused) {
  std::string class_id = "class";
  DDS_Security_DataHolder holder{};
  holder.class_id = class_id.data();
  holder.properties._length = spi::kMaxPropertiesPerToken + 1;
  EXPECT_EQ(token_from(&holder).error().code(), Code::length_out_of_range);
  holder.properties._length = 0;
  holder.binary_properties._length = 0xffffffff;
  EXPECT_EQ(token_from(&holder).error().code(), Code::length_out_of_range);

  DDS_Security_DataHolderSeq sequence{0, spi::kMaxTokensPerMessage + 1, &holder};
  EXPECT_EQ(CryptoTokens::from(&sequence).error().code(), Code::length_out_of_range);
  EXPECT_EQ(CryptoTokens::from(nullptr).error().code(), Code::null_argument);
  sequence = {1, 1, nullptr};
  EXPECT_EQ(CryptoTokens::from(&sequence).error().code(), Code::null_argument);
}

TEST(TokenTranslation, Credentials_TravelAsTextInTheirOrder) {
  const auto text = with_text_properties(
      {.class_id = "DDS:Auth:PKI-DH:1.0",
       .binary_properties = {{"c.id", {'p', 'e', 'm'}, true}, {"c.perm", {'x'}, true}}});
  ASSERT_TRUE(text);
  EXPECT_TRUE(text->binary_properties.empty());
  ASSERT_EQ(text->properties.size(), 2u);
  EXPECT_EQ(text->properties[0], (spi::Property{"c.id", "pem"}));
  EXPECT_EQ(text->properties[1], (spi::Property{"c.perm", "x"}));

  const auto refused = with_text_properties({.binary_properties = {{"c.perm", {'a', 0, 'b'}}}});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::text_holds_nul);
  EXPECT_EQ(refused.error().details().document, "c.perm");
}

// Found by fuzzing: the host was given more properties than a token may have when it is returned.
TEST(TokenTranslation, TextProperties_AreAsManyAsATokenHolds) {
  spi::Token token{.class_id = "DDS:Auth:PKI-DH:1.0",
                   .properties = spi::PropertyList(spi::kMaxPropertiesPerToken - 1),
                   .binary_properties = {{"c.id", {'p'}, true}}};
  const auto text = with_text_properties(token);
  ASSERT_TRUE(text);
  EXPECT_EQ(text->properties.size(), spi::kMaxPropertiesPerToken);
  token.binary_properties.push_back({"c.perm", {'x'}, true});
  const auto refused = with_text_properties(token);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::length_out_of_range);
}

TEST(TokenTranslation, PropertiesOfAQos_AreRead) {
  EXPECT_TRUE(properties_from(static_cast<const DDS_Security_Qos*>(nullptr))->empty());
  std::string name = "dds.sec.auth.identity_ca";
  std::string value = "file:ca.pem";
  DDS_Security_Property_t property{name.data(), value.data(), 0};
  DDS_Security_Qos qos{};
  qos.property.value = {1, 1, &property};
  const auto list = properties_from(&qos);
  ASSERT_TRUE(list);
  EXPECT_EQ(*list, (spi::PropertyList{{name, value, false}}));
}

}  // namespace
}  // namespace ddssec::cyclonedds
