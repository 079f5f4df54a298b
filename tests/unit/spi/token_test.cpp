#include "plugins/spi/token.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/hash.hpp"
#include "tests/support/code_of.hpp"

namespace ddssec::spi {
namespace {

Token sample() {
  return {.class_id = "DDS:Auth:PKI-DH:1.0",
          .properties = {{"dds.cert.sn", "CN=a"}, {"local", "x", false}},
          .binary_properties = {{"c.id", Bytes{1, 2, 3}}, {"c.perm", {}}}};
}

TEST(Token, EachByteOrder_RoundTripsWithoutWhatDoesNotPropagate) {
  for (auto endian : {Endian::big, Endian::little}) {
    Writer writer(endian);
    write_token(writer, sample());
    const auto octets = writer.take();
    Reader reader(octets, endian);
    auto expected = sample();
    expected.properties.pop_back();
    EXPECT_EQ(read_token(reader), expected);
    EXPECT_TRUE(reader.finish());
  }
}

TEST(Token, EveryTruncation_IsRefused) {
  Writer writer;
  write_token(writer, sample());
  const auto octets = writer.take();
  for (std::size_t size = 0; size < octets.size(); ++size) {
    Reader reader(BytesView(octets).first(size));
    EXPECT_THAT(test::code_of(read_token(reader)),
                testing::AnyOf(Code::truncated, Code::length_out_of_range))
        << size;
  }
}

// CVE-2025-62599, -62600, -62602: false lengths inside tokens.
TEST(Token, LyingCountsAndLengths_AreRefusedBeforeAllocating) {
  Writer writer;
  write_token(writer, sample());
  const auto honest = writer.take();
  for (std::size_t at = 0; at + 4 <= honest.size(); at += 4) {
    for (std::uint32_t lie : {0x7fffffffu, 0x80000000u, 0xffffffffu, 0xfffffffcu}) {
      auto octets = honest;
      for (int i = 0; i < 4; ++i) octets[at + i] = static_cast<std::uint8_t>(lie >> (24 - 8 * i));
      Reader reader(octets);
      const auto token = read_token(reader);
      EXPECT_LE(token ? token->properties.size() : 0, kMaxPropertiesPerToken);
    }
  }
}

TEST(Token, MorePropertiesThanTheBound_AreRefused) {
  Token token = sample();
  token.properties.assign(kMaxPropertiesPerToken + 1, {"n", "v"});
  Writer writer;
  write_token(writer, token);
  const auto octets = writer.take();
  Reader reader(octets);
  EXPECT_EQ(read_token(reader).error().code(), Code::length_out_of_range);
}

// Both vectors were computed independently from the rule of DDS-Security 1.2, clause 10.3.2.5.1.
TEST(BinaryProperties, KnownProperties_GiveTheHashInputOfTheHandshake) {
  const Bytes pdata = {0, 1, 0, 0};
  const NamedOctets a[] = {{"c.id", as_bytes("-----BEGIN")},
                           {"c.perm", as_bytes("P")},
                           {"c.pdata", pdata},
                           {"c.dsign_algo", as_bytes("ECDSA-SHA256")},
                           {"c.kagree_algo", as_bytes("ECDH+prime256v1-CEUM")}};
  EXPECT_EQ(serialize_binary_properties(a).size(), 152u);
  EXPECT_EQ(to_hex(sha256(serialize_binary_properties(a))),
            "f436fdded2a5dbcbf37a027eb2f6cc06eb9c4aeefdc47b9cdfd47847fd3222d7");
  const NamedOctets b[] = {{"c.id", as_bytes("A")},
                           {"c.perm", as_bytes("BC")},
                           {"c.pdata", as_bytes("DEF")},
                           {"c.dsign_algo", as_bytes("RSASSA-PSS-SHA256")},
                           {"c.kagree_algo", as_bytes("DH+MODP-2048-256x")}};
  EXPECT_EQ(serialize_binary_properties(b).size(), 149u);
  EXPECT_EQ(to_hex(sha256(serialize_binary_properties(b))),
            "f9edc5606d573e3fb7a762f35aee89f3555adfce6ea95a5d09123ff444b956b6");
}

}  // namespace
}  // namespace ddssec::spi
