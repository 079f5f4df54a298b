// One contract for all AEAD implementations, with vectors of other projects.
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
  Cipher with;
  Bytes key, iv, aad, plain, cipher, tag;
};

Iv iv_of(const Case& one) {
  Iv iv;
  std::ranges::copy(one.iv, iv.begin());
  return iv;
}

constexpr auto kAes128 = Cipher::aes128_gcm;
constexpr auto kAes256 = Cipher::aes256_gcm;
constexpr auto kChacha = Cipher::chacha20_poly1305;
constexpr Cipher kCiphers[] = {kAes128, kAes256, kChacha};

Cipher aes_of(const Bytes& key) { return key.size() == 16 ? kAes128 : kAes256; }

TagView tag_of(const Bytes& octets) { return TagView(octets.data(), kTagSize); }

class Aead : public ::testing::TestWithParam<const AeadBackend*> {
 protected:
  static void expand(ExpandedKey& key, Cipher cipher, const Bytes& octets) {
    ASSERT_TRUE(key.expand(*GetParam(), cipher, octets));
  }

  static void expect_seals(const Case& one) {
    ExpandedKey key;
    expand(key, one.with, one.key);
    Bytes out(one.plain.size()), tag(kTagSize);
    ASSERT_TRUE(
        key.seal({iv_of(one), one.aad, one.plain, out.data(), TagOut(tag.data(), kTagSize)}));
    EXPECT_EQ(to_hex(out), to_hex(one.cipher));
    EXPECT_EQ(to_hex(tag), to_hex(one.tag));
  }

  static bool opens(const Case& one) {
    ExpandedKey key;
    expand(key, one.with, one.key);
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

// Calls `f` for the file's tests with a nonce of our size, because the interface takes no other
// one. Returns their number.
template <class F>
std::size_t for_each_wycheproof(const std::string& name, F&& f) {
  std::size_t tried = 0;
  const auto file = json_file("wycheproof/" + name);
  for (const auto& group : file["testGroups"]) {
    if (group["ivSize"] != 96) continue;
    for (const auto& test : group["tests"]) {
      SCOPED_TRACE(test["tcId"].dump());
      const auto key = hex(test["key"]);
      const auto cipher = name.starts_with("chacha") ? kChacha : aes_of(key);
      const Case one{cipher,           key,
                     hex(test["iv"]),  hex(test["aad"]),
                     hex(test["msg"]), hex(test["ct"]),
                     hex(test["tag"])};
      f(one, test["result"] == "valid");
      ++tried;
    }
  }
  return tried;
}

TEST_P(Aead, WycheproofVectors_AreReproduced) {
  for (const auto* const name : {"aes_gcm_test.json", "chacha20_poly1305_test.json"}) {
    const auto tried = for_each_wycheproof(name, [](const Case& one, bool valid) {
      if (valid) expect_seals(one);
      EXPECT_EQ(opens(one), valid);
    });
    EXPECT_GT(tried, 50u) << name;
  }
}

// RFC 8439, section 2.8.2.
TEST_P(Aead, Rfc8439Example_IsReproduced) {
  const auto text = as_bytes(
      "Ladies and Gentlemen of the class of '99: If I could offer you only one tip for the future, "
      "sunscreen would be it.");
  const Case one{kChacha,
                 hex("808182838485868788898a8b8c8d8e8f909192939495969798999a9b9c9d9e9f"),
                 hex("070000004041424344454647"),
                 hex("50515253c0c1c2c3c4c5c6c7"),
                 to_bytes(text),
                 hex("d31a8d34648e60db7b86afbc53ef7ec2a4aded51296e08fea9e2b5a736ee62d6"
                     "3dbea45e8ca9671282fafb69da92728b1a71de0a9e060b2905d6a5b67ecd3b36"
                     "92ddbd7f2d778b8c9803aee328091b58fab324e4fad675945585808b4831d7bc"
                     "3ff4def08e4b7a9de576d26586cec64b6116"),
                 hex("1ae10b594f09e26a7e902ecbd0600691")};
  expect_seals(one);
  EXPECT_TRUE(opens(one));
}

// RFC 8439, appendix A.5.
TEST_P(Aead, Rfc8439DecryptionExample_IsReproduced) {
  const Case one{
      kChacha,
      hex("1c9240a5eb55d38af333888604f6b5f0473917c1402b80099dca5cbc207075c0"),
      hex("000000000102030405060708"),
      hex("f33388860000000000004e91"),
      to_bytes(
          as_bytes("Internet-Drafts are draft documents valid for a maximum of six months and may "
                   "be updated, replaced, or obsoleted by other documents at any time. It is "
                   "inappropriate to use Internet-Drafts as reference material or to cite them "
                   "other than as /\xe2\x80\x9cwork in progress./\xe2\x80\x9d")),
      hex("64a0861575861af460f062c79be643bd5e805cfd345cf389f108670ac76c8cb2"
          "4c6cfc18755d43eea09ee94e382d26b0bdb7b73c321b0100d4f03b7f355894cf"
          "332f830e710b97ce98c8a84abd0b948114ad176e008d33bd60f982b1ff37c855"
          "9797a06ef4f0ef61c186324e2b3506383606907b6a7c02b0f9f6157b53c867e4"
          "b9166c767b804d46a59b5216cde7a4e99040c5a40433225ee282a1b0a06c523e"
          "af4534d7f83fa1155b0047718cbc546a0d072b04b3564eea1b422273f548271a"
          "0bb2316053fa76991955ebd63159434ecebb4e466dae5a1073a6727627097a10"
          "49e617d91d361094fa68f0ff77987130305beaba2eda04df997b714d6c6f2c29"
          "a6ad5cb4022b02709b"),
      hex("eead9d67890cbb22392336fea1851f38")};
  EXPECT_TRUE(opens(one));
  expect_seals(one);
}

TEST_P(Aead, WycheproofGmacVectors_AreReproduced) {
  std::size_t tried = 0;
  const auto file = json_file("wycheproof/aes_gmac_test.json");
  for (const auto& group : file["testGroups"]) {
    if (group["ivSize"] != 96) continue;
    for (const auto& test : group["tests"]) {
      SCOPED_TRACE(test["tcId"].dump());
      ExpandedKey key;
      expand(key, aes_of(hex(test["key"])), hex(test["key"]));
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
    cases.push_back({aes_of(fields["Key"]), fields["Key"], fields["IV"], fields["AAD"],
                     fields["PT"], fields["CT"], fields["Tag"]});
  }
  return cases;
}

TEST_P(Aead, NistEncryptionVectors_AreReproduced) {
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

Case sealed(std::size_t size, Cipher cipher, std::size_t aad_size = 0) {
  Case one{cipher,
           Bytes(key_size_of(cipher), 0x11),
           Bytes(12, 0x22),
           Bytes(aad_size, 0x44),
           Bytes(size, 0x33),
           Bytes(size),
           Bytes(kTagSize)};
  ExpandedKey key;
  EXPECT_TRUE(key.expand(*aead_backend(AeadChoice::openssl), cipher, one.key));
  EXPECT_TRUE(key.seal(
      {iv_of(one), one.aad, one.plain, one.cipher.data(), TagOut(one.tag.data(), kTagSize)}));
  return one;
}

TEST_P(Aead, EverySize_AgreesWithOpenssl) {
  for (const auto cipher : kCiphers) {
    for (std::size_t size = 0; size < 600; ++size) {
      expect_seals(sealed(size, cipher, size % 37));
      expect_seals(sealed(size, cipher, 600 - size));
      EXPECT_TRUE(opens(sealed(size, cipher)));
    }
    for (std::size_t aad = 0; aad < 2000; ++aad) expect_seals(sealed(0, cipher, aad));
    expect_seals(sealed(65536 + 7, cipher));
    EXPECT_TRUE(opens(sealed(65536 + 7, cipher, 70001)));
  }
}

TEST_P(Aead, TagWrongInAnyBit_IsRefused) {
  for (const auto cipher : kCiphers) {
    auto one = sealed(40, cipher, 8);
    for (std::size_t bit = 0; bit < 8 * kTagSize; ++bit) {
      one.tag[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      EXPECT_FALSE(opens(one)) << bit;
      one.tag[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    }
    EXPECT_TRUE(opens(one));
    one.tag = Bytes(kTagSize);
    EXPECT_FALSE(opens(one));
  }
}

TEST_P(Aead, OtherIvAadCipherOrKey_IsRefused) {
  for (const auto cipher : kCiphers)
    for (auto Case::*field : {&Case::iv, &Case::aad, &Case::cipher, &Case::key}) {
      auto bad = sealed(40, cipher, 8);
      (bad.*field).back() ^= 1;
      EXPECT_FALSE(opens(bad));
    }
}

TEST_P(Aead, SameBuffer_WorksInPlace) {
  for (const auto cipher : kCiphers)
    for (const std::size_t size : {1u, 16u, 63u, 64u, 65u, 1000u, 5000u}) {
      const auto one = sealed(size, cipher);
      ExpandedKey key;
      expand(key, one.with, one.key);
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

TEST_P(Aead, EverySize_WritesNoOctetBeside) {
  for (const auto cipher : kCiphers)
    for (std::size_t size = 0; size < 300; ++size) {
      const auto one = sealed(size, cipher);
      ExpandedKey key;
      expand(key, one.with, one.key);
      Bytes out(size + 32, 0xcd), tag(kTagSize);
      ASSERT_TRUE(
          key.seal({iv_of(one), {}, one.plain, out.data() + 16, TagOut(tag.data(), kTagSize)}));
      EXPECT_EQ(to_hex(BytesView(out).first(16)), to_hex(Bytes(16, 0xcd)));
      EXPECT_EQ(to_hex(BytesView(out).last(16)), to_hex(Bytes(16, 0xcd)));
    }
}

TEST_P(Aead, OtherKeySizesAndNoKey_AreRefused) {
  ExpandedKey key;
  for (const std::size_t size : {0u, 8u, 15u, 17u, 24u, 31u, 33u})
    for (const auto cipher : {Cipher::aes128_gcm, Cipher::aes256_gcm, Cipher::chacha20_poly1305})
      EXPECT_EQ(key.expand(*GetParam(), cipher, Bytes(size, 1)).error().code(),
                Code::length_out_of_range);
  Bytes tag(kTagSize);
  EXPECT_FALSE(key.mac({}, {}, TagOut(tag.data(), kTagSize)));
  EXPECT_FALSE(key.open({}, {}, {}, nullptr, tag_of(tag)));
}

TEST_P(Aead, Destruction_LeavesNothingOfTheKey) {
  for (const auto cipher : {kAes256, kChacha}) {
    alignas(ExpandedKey) std::array<std::byte, sizeof(ExpandedKey)> place{};
    auto* const key = new (place.data()) ExpandedKey;
    expand(*key, cipher, Bytes(32, 0x77));
    key->~ExpandedKey();
    const auto* const octets = static_cast<const std::uint8_t*>(static_cast<void*>(place.data()));
    EXPECT_EQ(to_hex({octets, kKeyStorage}), to_hex(Bytes(kKeyStorage)));
  }
}

INSTANTIATE_TEST_SUITE_P(Backends, Aead,
                         ::testing::ValuesIn(aead_backends().begin(), aead_backends().end()),
                         [](const auto& info) {
                           return info.param->name() == "openssl" ? "openssl" : "ipsec_mb";
                         });

TEST(AeadChoice, EveryMachine_OffersOpenssl) {
  ASSERT_NE(aead_backend(AeadChoice::openssl), nullptr);
  EXPECT_EQ(aead_backend(AeadChoice::openssl)->name(), "openssl");
  EXPECT_EQ(aead_backend(AeadChoice::automatic), aead_backends().front());
}

}  // namespace
}  // namespace ddssec::cryptography
