#include "plugins/spi/token.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "base/hash.hpp"
#include "tests/support/code_of.hpp"
#include "tests/support/counted_memory.hpp"

namespace ddssec::spi {
namespace {

Token sample() {
  return {.class_id = "DDS:Auth:PKI-DH:1.0",
          .properties = {{"dds.cert.sn", "CN=a"}, {"local", "x", false}},
          .binary_properties = {{"c.id", Bytes{1, 2, 3}}, {"c.perm", {}}}};
}

TEST(Token, BinaryOctets_AreThoseOfAllBinaryValues) {
  EXPECT_EQ(binary_octets(Token()), 0u);
  auto token = sample();
  EXPECT_EQ(binary_octets(token), 3u);
  token.binary_properties[1].value.assign(5, 0);
  EXPECT_EQ(binary_octets(token), 8u);
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

// The octets of sample() with a lie in place of the four octets at `at`.
Bytes with_lie(BytesView honest, std::size_t at, std::uint32_t lie) {
  auto octets = to_bytes(honest);
  for (unsigned i = 0; i < 4; ++i) octets[at + i] = static_cast<std::uint8_t>(lie >> (24 - 8 * i));
  return octets;
}

constexpr std::uint32_t kLies[] = {0x7fffffff, 0x80000000, 0xffffffff, 0xfffffffc};

// CVE-2025-62599, -62600, -62602: false lengths inside tokens.
TEST(Token, LyingCountsAndLengths_AreRefused) {
  Writer writer;
  write_token(writer, sample());
  const auto honest = writer.take();
  // The length of the class id; for each list its number of properties, and the lengths of the name
  // and the value of each property.
  constexpr std::size_t kCounts[] = {0, 24, 28, 44, 56, 60, 72, 80, 92};
  ASSERT_EQ(honest.size(), 96u);
  for (const auto at : kCounts)
    for (const auto lie : kLies) {
      const auto octets = with_lie(honest, at, lie);
      Reader reader(octets);
      EXPECT_THAT(test::code_of(read_token(reader)),
                  testing::AnyOf(Code::truncated, Code::length_out_of_range))
          << at;
    }
}

TEST(Token, LiesAnywhere_AllocateNoMoreThanTheTruth) {
  Writer writer;
  write_token(writer, sample());
  const auto honest = writer.take();
  const auto allocated_by = [](BytesView octets) {
    const auto before = counted_memory::octets_ever();
    Reader reader(octets);
    static_cast<void>(read_token(reader));
    return counted_memory::octets_ever() - before;
  };
  const auto truth = allocated_by(honest);
  EXPECT_GT(truth, 0);
  for (std::size_t at = 0; at + 4 <= honest.size(); at += 4)
    for (const auto lie : kLies) EXPECT_LE(allocated_by(with_lie(honest, at, lie)), truth) << at;
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
