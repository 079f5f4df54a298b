// Key material as octets: what is read, and what is refused.
#include "plugins/cryptography/key_material.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/unit/cryptography/sample_key_material.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

TEST(KeyMaterialOctets, MaterialCutAnywhere_IsRefused) {
  for (const auto kind : {kAes128Gmac, kAes256Gcm, kChachaPoly1305Mac, kChachaPoly1305})
    for (const bool receiver : {false, true}) {
      auto octets = serialize_key_material(material(kind, 1, receiver));
      for (std::size_t size = 0; size < octets.size(); ++size)
        EXPECT_EQ(code_of(parse_key_material(BytesView(octets).first(size))),
                  Code::key_material_length)
            << size;
      EXPECT_TRUE(parse_key_material(octets));
      octets.push_back(0);
      EXPECT_EQ(code_of(parse_key_material(octets)), Code::key_material_length);
    }
}

TEST(KeyMaterialOctets, NoneKind_IsReadInBothSizesOfThePeers) {
  for (const std::size_t size : {24u, 44u, 128u})
    EXPECT_TRUE(parse_key_material(Bytes(size)).value().is_none());
  for (const std::size_t size : {4u, 23u, 129u, 100000u})
    EXPECT_EQ(code_of(parse_key_material(Bytes(size))), Code::key_material_length);
  Bytes octets(44);
  octets[40] = 1;
  EXPECT_EQ(code_of(parse_key_material(octets)), Code::key_material_length);
}

TEST(KeyMaterialOctets, UnknownKinds_AreRefused) {
  auto octets = serialize_key_material(material(kAes256Gcm));
  for (const TransformKind kind : {TransformKind{{0, 0, 0, 5}}, TransformKind{{0, 0, 0, 0x80}},
                                   TransformKind{{0x56, 0, 0, 0x80}}, TransformKind{{0, 0, 1, 0}},
                                   TransformKind{{1, 0, 0, 5}}}) {
    std::ranges::copy(kind.octets, octets.begin());
    EXPECT_EQ(code_of(parse_key_material(octets)), Code::key_material_kind_unknown);
  }
}

TEST(KeyMaterialOctets, LyingLengths_AreRefused) {
  const auto good = serialize_key_material(material(kAes256Gcm, 1, true));
  for (const std::size_t length_at : {4u, 44u, 84u})
    for (std::size_t octet = 0; octet < 4; ++octet)
      for (const std::uint8_t value : {1, 16, 33, 255}) {
        auto bad = good;
        bad[length_at + octet] = value;
        EXPECT_EQ(code_of(parse_key_material(bad)), Code::key_material_length);
      }
}

TEST(KeyMaterialOctets, ZeroKeysAndIds_AreRefused) {
  const auto good = serialize_key_material(material(kAes256Gcm, 1, true));
  const auto zeroed = [&](std::size_t at, std::size_t count) {
    auto bad = good;
    std::fill_n(bad.begin() + static_cast<std::ptrdiff_t>(at), count, std::uint8_t{0});
    return code_of(parse_key_material(bad));
  };
  EXPECT_EQ(zeroed(8, 32), Code::key_material_all_zero);
  EXPECT_EQ(zeroed(48, 32), Code::key_material_all_zero);
  EXPECT_EQ(zeroed(88, 32), Code::key_material_all_zero);
  EXPECT_EQ(zeroed(40, 4), Code::key_material_key_id) << "0 is the key exchange's";
  EXPECT_EQ(zeroed(80, 4), Code::key_material_length) << "a receiver key without id";
}

}  // namespace
}  // namespace ddssec::cryptography::testing
