#include "pki/pem_block.hpp"

#include <gtest/gtest.h>

#include "pki/openssl.hpp"

namespace ddssec::pki {
namespace {

// The block holds the octets 1, 2 and 3.
constexpr std::string_view kBlock = "-----BEGIN THING-----\nAQID\n-----END THING-----\n";

TEST(PemBlock, TextsBetweenBlocks_AreSkipped) {
  const auto text = "first\n" + std::string(kBlock) + "between\n" + std::string(kBlock);
  const auto bio = bio_over(as_bytes(text));
  for (int i = 0; i < 2; ++i) {
    const auto block = next_pem_block(bio.get());
    ASSERT_TRUE(block && *block) << i;
    EXPECT_EQ((*block)->label, "THING");
    EXPECT_EQ((*block)->der, (Bytes{1, 2, 3}));
  }
  const auto end = next_pem_block(bio.get());
  ASSERT_TRUE(end);
  EXPECT_FALSE(*end);
}

TEST(PemBlock, CutBlock_IsMalformed) {
  const auto bio = bio_over(as_bytes(kBlock.substr(0, 30)));
  const auto block = next_pem_block(bio.get());
  ASSERT_FALSE(block);
  EXPECT_EQ(block.error().code(), Code::malformed);
}

TEST(PemBlock, BlockWithHeaders_IsRefused) {
  const std::string text =
      "-----BEGIN THING-----\nProc-Type: 4,ENCRYPTED\n\nAQID\n-----END THING-----\n";
  const auto bio = bio_over(as_bytes(text));
  const auto block = next_pem_block(bio.get());
  ASSERT_FALSE(block);
  EXPECT_EQ(block.error().code(), Code::malformed);
}

TEST(Der, Sequence_IsRecognizedByItsTagAndLength) {
  EXPECT_TRUE(is_der(Bytes{0x30, 1, 5}));
  EXPECT_TRUE(is_der(Bytes{0x30, 0x82, 1, 0}));
  EXPECT_FALSE(is_der(Bytes{0x30, 2, 5})) << "another length";
  EXPECT_FALSE(is_der(Bytes{0x30, 0x80})) << "without a length";
  EXPECT_FALSE(is_der(Bytes{0x31, 1, 5}));
  EXPECT_FALSE(is_der(Bytes{0x30}));
  EXPECT_FALSE(is_der(as_bytes(kBlock)));
}

}  // namespace
}  // namespace ddssec::pki
