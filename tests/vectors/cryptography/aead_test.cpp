// One contract for all AES-GCM implementations, with others' vectors.
#include "plugins/cryptography/aead.hpp"

#include <fstream>
#include <map>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/support/test_data.hpp"

namespace ddssec::cryptography {
namespace {

Bytes hex(const std::string& digits) { return from_hex(digits).value(); }

struct Case {
  Bytes key, iv, aad, plain, cipher, tag;
};

Iv iv_of(const Case& one) {
  Iv iv;
  std::ranges::copy(one.iv, iv.begin());
  return iv;
}

TagView tag_of(const Bytes& octets) { return TagView(octets.data(), kTagSize); }

class Aead : public ::testing::TestWithParam<const AeadBackend*> {
 protected:
  static void expand(ExpandedKey& key, const Bytes& octets) {
    ASSERT_TRUE(key.expand(*GetParam(), octets));
  }

  static void expect_seals(const Case& one) {
    ExpandedKey key;
    expand(key, one.key);
    Bytes out(one.plain.size()), tag(kTagSize);
    ASSERT_TRUE(
        key.seal({iv_of(one), one.aad, one.plain, out.data(), TagOut(tag.data(), kTagSize)}));
    EXPECT_EQ(to_hex(out), to_hex(one.cipher));
    EXPECT_EQ(to_hex(tag), to_hex(one.tag));
  }

  static bool opens(const Case& one) {
    ExpandedKey key;
    expand(key, one.key);
    Bytes out(one.cipher.size(), 0xee);
    const bool opened = key.open(iv_of(one), one.aad, one.cipher, out.data(), tag_of(one.tag));
    EXPECT_EQ(to_hex(out), to_hex(opened ? one.plain : Bytes(out.size())));
    return opened;
  }
};

nlohmann::json json_file(const std::string& name) {
  std::ifstream file(test::data_path(name));
  return nlohmann::json::parse(file);
}

TEST_P(Aead, WycheproofGcm) {
  std::size_t tried = 0;
  const auto file = json_file("wycheproof/aes_gcm_test.json");
  for (const auto& group : file["testGroups"]) {
    if (group["ivSize"] != 96) continue;
    for (const auto& test : group["tests"]) {
      SCOPED_TRACE(test["tcId"].dump());
      const Case one{hex(test["key"]), hex(test["iv"]), hex(test["aad"]),
                     hex(test["msg"]), hex(test["ct"]), hex(test["tag"])};
      const bool valid = test["result"] == "valid";
      if (valid) expect_seals(one);
      EXPECT_EQ(opens(one), valid);
      ++tried;
    }
  }
  EXPECT_GT(tried, 50u);
}

TEST_P(Aead, WycheproofGmac) {
  std::size_t tried = 0;
  const auto file = json_file("wycheproof/aes_gmac_test.json");
  for (const auto& group : file["testGroups"]) {
    if (group["ivSize"] != 96) continue;
    for (const auto& test : group["tests"]) {
      SCOPED_TRACE(test["tcId"].dump());
      ExpandedKey key;
      expand(key, hex(test["key"]));
      Iv iv;
      std::ranges::copy(hex(test["iv"]), iv.begin());
      const auto tag = hex(test["tag"]);
      EXPECT_EQ(key.verify(iv, hex(test["msg"]), tag_of(tag)), test["result"] == "valid");
      ++tried;
    }
  }
  EXPECT_GT(tried, 50u);
}

std::vector<Case> nist_file(const std::string& name) {
  std::ifstream file(test::data_path("pyca-cryptography-vectors/" + name));
  std::vector<Case> cases;
  std::map<std::string, Bytes> fields;
  for (std::string line; std::getline(file, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    const auto equals = line.find(" =");
    if (equals == std::string::npos || line.front() == '[' || line.starts_with("Count")) continue;
    const auto value = line.substr(std::min(line.size(), equals + 3));
    fields[line.substr(0, equals)] = hex(value);
    if (!line.starts_with("Tag")) continue;
    cases.push_back(
        {fields["Key"], fields["IV"], fields["AAD"], fields["PT"], fields["CT"], fields["Tag"]});
  }
  return cases;
}

TEST_P(Aead, NistEncrypt) {
  for (const auto* const name :
       {"gcmEncryptExtIV128_iv96_tag128.rsp", "gcmEncryptExtIV256_iv96_tag128.rsp"}) {
    const auto cases = nist_file(name);
    EXPECT_GT(cases.size(), 100u) << name;
    for (const auto& one : cases) {
      expect_seals(one);
      EXPECT_TRUE(opens(one));
    }
  }
}

Case sealed(std::size_t size, std::size_t key_size, std::size_t aad_size = 0) {
  Case one{Bytes(key_size, 0x11), Bytes(12, 0x22), Bytes(aad_size, 0x44),
           Bytes(size, 0x33),     Bytes(size),     Bytes(kTagSize)};
  ExpandedKey key;
  EXPECT_TRUE(key.expand(*aead_backend(AeadChoice::openssl), one.key));
  EXPECT_TRUE(key.seal(
      {iv_of(one), one.aad, one.plain, one.cipher.data(), TagOut(one.tag.data(), kTagSize)}));
  return one;
}

TEST_P(Aead, AgreesWithOpensslAtEverySize) {
  for (std::size_t size = 0; size < 600; ++size) {
    expect_seals(sealed(size, 16, size % 37));
    expect_seals(sealed(size, 32, 600 - size));
    EXPECT_TRUE(opens(sealed(size, size % 2 == 0 ? 16 : 32)));
  }
  expect_seals(sealed(65536 + 7, 32));
}

TEST_P(Aead, RefusesATagWrongInAnyBit) {
  auto one = sealed(40, 32, 8);
  for (std::size_t bit = 0; bit < 8 * kTagSize; ++bit) {
    one.tag[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    EXPECT_FALSE(opens(one)) << bit;
    one.tag[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
  }
  EXPECT_TRUE(opens(one));
  one.tag = Bytes(kTagSize);
  EXPECT_FALSE(opens(one));
}

TEST_P(Aead, RefusesOtherIvAadAndCipher) {
  const auto good = sealed(40, 16, 8);
  for (auto Case::*field : {&Case::iv, &Case::aad, &Case::cipher, &Case::key}) {
    auto bad = good;
    (bad.*field).back() ^= 1;
    EXPECT_FALSE(opens(bad));
  }
}

TEST_P(Aead, WorksInPlace) {
  for (const std::size_t size : {1u, 16u, 63u, 64u, 1000u, 5000u}) {
    const auto one = sealed(size, 32);
    ExpandedKey key;
    expand(key, one.key);
    Bytes buffer = one.plain, tag(kTagSize);
    ASSERT_TRUE(key.seal({iv_of(one), {}, buffer, buffer.data(), TagOut(tag.data(), kTagSize)}));
    EXPECT_EQ(buffer, one.cipher);
    ASSERT_TRUE(key.open(iv_of(one), {}, buffer, buffer.data(), tag_of(tag)));
    EXPECT_EQ(buffer, one.plain);
    tag[3] ^= 4;
    buffer = one.cipher;
    EXPECT_FALSE(key.open(iv_of(one), {}, buffer, buffer.data(), tag_of(tag)));
    EXPECT_EQ(buffer, Bytes(size)) << "nothing that did not verify stays";
  }
}

TEST_P(Aead, WritesNoOctetBeside) {
  for (std::size_t size = 0; size < 80; ++size) {
    const auto one = sealed(size, 16);
    ExpandedKey key;
    expand(key, one.key);
    Bytes out(size + 32, 0xcd), tag(kTagSize);
    ASSERT_TRUE(
        key.seal({iv_of(one), {}, one.plain, out.data() + 16, TagOut(tag.data(), kTagSize)}));
    EXPECT_EQ(to_hex(BytesView(out).first(16)), to_hex(Bytes(16, 0xcd)));
    EXPECT_EQ(to_hex(BytesView(out).last(16)), to_hex(Bytes(16, 0xcd)));
  }
}

TEST_P(Aead, RefusesOtherKeySizesAndNoKey) {
  ExpandedKey key;
  for (const std::size_t size : {0u, 8u, 15u, 17u, 24u, 31u, 33u})
    EXPECT_EQ(key.expand(*GetParam(), Bytes(size, 1)).error().code(), Code::length_out_of_range);
  Bytes tag(kTagSize);
  EXPECT_FALSE(key.mac({}, {}, TagOut(tag.data(), kTagSize)));
  EXPECT_FALSE(key.open({}, {}, {}, nullptr, tag_of(tag)));
}

TEST_P(Aead, LeavesNothingOfTheKeyBehind) {
  alignas(ExpandedKey) std::array<std::byte, sizeof(ExpandedKey)> place{};
  auto* const key = new (place.data()) ExpandedKey;
  expand(*key, Bytes(32, 0x77));
  key->~ExpandedKey();
  const auto* const octets = static_cast<const std::uint8_t*>(static_cast<void*>(place.data()));
  EXPECT_EQ(to_hex({octets, kKeyStorage}), to_hex(Bytes(kKeyStorage)));
}

INSTANTIATE_TEST_SUITE_P(Backends, Aead,
                         ::testing::ValuesIn(aead_backends().begin(), aead_backends().end()),
                         [](const auto& info) {
                           return info.param->name() == "openssl" ? "openssl" : "ipsec_mb";
                         });

TEST(AeadChoice, OffersOpensslEverywhere) {
  ASSERT_NE(aead_backend(AeadChoice::openssl), nullptr);
  EXPECT_EQ(aead_backend(AeadChoice::openssl)->name(), "openssl");
  EXPECT_EQ(aead_backend(AeadChoice::automatic), aead_backends().front());
}

}  // namespace
}  // namespace ddssec::cryptography
