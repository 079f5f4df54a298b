#include <openssl/core_names.h>
#include <openssl/dh.h>

#include "pki/openssl.hpp"
#include "pki_fixture.hpp"
#include "tests/support/code_of.hpp"
#include "tests/support/known_key.hpp"

namespace ddssec::pki {
namespace {

constexpr auto kP256 = KeyAgreementKind::ecdh_p256;
constexpr auto kP384 = KeyAgreementKind::ecdh_p384;
constexpr auto kModp = KeyAgreementKind::dh_modp_2048_256;

class Elliptic : public testing::TestWithParam<KeyAgreementKind> {};
INSTANTIATE_TEST_SUITE_P(Curves, Elliptic, testing::Values(kP256, kP384));

// T48 (docs/attacks.md): points and Diffie-Hellman values outside the group.
TEST_P(Elliptic, OnlyPointsOfTheCurveAtFullLength_AreTaken) {
  const auto key = *EphemeralKey::generate(GetParam());
  auto point = *key.public_octets();
  ASSERT_EQ(point.size(), GetParam() == kP256 ? 65u : 97u);
  EXPECT_EQ(PeerPublicKey::parse(GetParam(), point)->encoding(), PublicKeyEncoding::point);
  for (std::size_t size = 0; size < point.size(); ++size)
    EXPECT_CODE(PeerPublicKey::parse(GetParam(), BytesView(point).first(size)),
                public_key_malformed);
  for (std::size_t at = 1; at < point.size(); ++at) {
    point[at] ^= 1;
    EXPECT_CODE(PeerPublicKey::parse(GetParam(), point), public_key_not_in_group);
    point[at] ^= 1;
  }
  auto longer = point;
  longer.push_back(0);
  EXPECT_CODE(PeerPublicKey::parse(GetParam(), longer), public_key_malformed);
  auto compressed = Bytes(point.begin(), point.begin() + static_cast<long>(point.size() / 2 + 1));
  compressed[0] = static_cast<std::uint8_t>(2 + (point.back() & 1));
  EXPECT_CODE(PeerPublicKey::parse(GetParam(), compressed), public_key_malformed);
  auto hybrid = point;
  hybrid[0] = static_cast<std::uint8_t>(6 + (point.back() & 1));
  EXPECT_CODE(PeerPublicKey::parse(GetParam(), hybrid), public_key_malformed);
  EXPECT_CODE(PeerPublicKey::parse(GetParam(), Bytes{0}), public_key_not_in_group);
  const auto other = *EphemeralKey::generate(GetParam() == kP256 ? kP384 : kP256);
  EXPECT_CODE(PeerPublicKey::parse(GetParam(), *other.public_octets()), public_key_malformed);
  EXPECT_CODE(PeerPublicKey::parse(GetParam(), Bytes(point.size(), 0)), public_key_malformed);
}

TEST(KeyAgreement, Kinds_DoNotMix) {
  const auto a = *EphemeralKey::generate(kP256);
  const auto b = *EphemeralKey::generate(kP384);
  EXPECT_CODE(a.derive(*PeerPublicKey::parse(kP384, *b.public_octets())), key_agreement_mismatch);
}

BignumPtr parameter(const char* name) {
  std::string group = "dh_2048_256";
  const OSSL_PARAM list[] = {
      OSSL_PARAM_construct_utf8_string(OSSL_PKEY_PARAM_GROUP_NAME, group.data(), 0),
      OSSL_PARAM_construct_end()};
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_name(nullptr, "DHX", nullptr));
  EVP_PKEY* raw = nullptr;
  EVP_PKEY_fromdata_init(context.get());
  EVP_PKEY_fromdata(context.get(), &raw, EVP_PKEY_KEY_PARAMETERS, const_cast<OSSL_PARAM*>(list));
  const PkeyPtr owner(raw);
  BIGNUM* value = nullptr;
  EVP_PKEY_get_bn_param(raw, name, &value);
  return BignumPtr(value);
}

Bytes octets_of(const BignumPtr& number) {
  Bytes out(static_cast<std::size_t>(BN_num_bytes(number.get())));
  BN_bn2bin(number.get(), out.data());
  return out;
}

Bytes der_of(BytesView value) {
  const BignumPtr number(BN_bin2bn(value.data(), static_cast<int>(value.size()), nullptr));
  const Asn1IntegerPtr integer(BN_to_ASN1_INTEGER(number.get(), nullptr));
  unsigned char* raw = nullptr;
  const int size = i2d_ASN1_INTEGER(integer.get(), &raw);
  const OpensslMemoryPtr owner(raw);
  return Bytes(raw, raw + size);
}

// T48 (docs/attacks.md): points and Diffie-Hellman values outside the group.
TEST(Modp, ValuesOutsideTheSubgroup_AreRefusedInBothEncodings) {
  const auto p = parameter(OSSL_PKEY_PARAM_FFC_P);
  const BignumPtr value(BN_dup(p.get()));
  std::vector<Bytes> bad = {{0}, {1}, {2}, octets_of(p)};
  BN_sub_word(value.get(), 1);
  bad.push_back(octets_of(value));  // p - 1
  BN_sub_word(value.get(), 1);
  bad.push_back(octets_of(value));  // p - 2
  BN_add_word(value.get(), 3);
  bad.push_back(octets_of(value));  // p + 1
  bad.push_back(Bytes(256, 0xff));
  for (const auto& octets : bad) {
    EXPECT_CODE(PeerPublicKey::parse(kModp, octets), public_key_not_in_group);
    EXPECT_CODE(PeerPublicKey::parse(kModp, der_of(octets)), public_key_not_in_group);
  }
  EXPECT_CODE(PeerPublicKey::parse(kModp, {}), public_key_malformed);
  EXPECT_CODE(PeerPublicKey::parse(kModp, Bytes(257, 1)), public_key_malformed);
  EXPECT_CODE(PeerPublicKey::parse(kModp, Bytes(262, 1)), public_key_malformed);
  EXPECT_CODE(PeerPublicKey::parse(kModp, Bytes(100000, 1)), public_key_malformed);
}

TEST(Modp, BothEncodings_AreWrittenAndRecognised) {
  const auto key = *EphemeralKey::generate(kModp);
  const auto plain = *key.public_octets(PublicKeyEncoding::plain_integer);
  const auto der = *key.public_octets(PublicKeyEncoding::der_integer);
  EXPECT_EQ(der, der_of(plain));
  EXPECT_EQ(PeerPublicKey::parse(kModp, plain)->encoding(), PublicKeyEncoding::plain_integer);
  EXPECT_EQ(PeerPublicKey::parse(kModp, der)->encoding(), PublicKeyEncoding::der_integer);
  // A part of the DER form that is not longer than the modulus is read as a plain integer.
  for (std::size_t size = 0; size < der.size(); size += 5)
    EXPECT_EQ(test::code_of(PeerPublicKey::parse(kModp, BytesView(der).first(size))),
              size == 0 || size > 256 ? Code::public_key_malformed : Code::public_key_not_in_group)
        << size;
  auto trailing = der;
  trailing.push_back(0);
  EXPECT_CODE(PeerPublicKey::parse(kModp, trailing), public_key_malformed);
}

// One of 256 shared values begins with a zero octet, and peers hash it without this octet.
TEST(Modp, SharedValuesWithLeadingZeros_AreHashedWithoutThem) {
  const auto p = parameter(OSSL_PKEY_PARAM_FFC_P);
  const auto mine = *KnownKey::from_private(kModp, Bytes{0x12, 0x34, 0x56, 0x78});
  const auto base = *mine.public_octets();
  const BignumPtr y(BN_bin2bn(base.data(), static_cast<int>(base.size()), nullptr));
  const BignumPtr z(BN_new());
  const std::unique_ptr<BN_CTX, Deleter<BN_CTX_free>> context(BN_CTX_new());
  int short_ones = 0;
  for (unsigned i = 1; i < 5000 && short_ones < 2; ++i) {
    const BignumPtr exponent(BN_new());
    BN_set_word(exponent.get(), i);
    BN_mod_exp(z.get(), y.get(), exponent.get(), p.get(), context.get());
    const auto expected = octets_of(z);
    if (expected.size() >= 256 && i > 3) continue;
    short_ones += expected.size() < 256 ? 1 : 0;
    const auto other = *KnownKey::from_private(kModp, octets_of(exponent));
    EXPECT_EQ(*mine.derive(*other.public_octets()), *AgreedSecret::copy_of(sha256(expected)));
    EXPECT_EQ(*other.derive(base), *AgreedSecret::copy_of(sha256(expected)));
  }
  EXPECT_EQ(short_ones, 2);
}

TEST(Modp, APublicValueWithLeadingZeros_IsWrittenWithoutThem) {
  for (unsigned i = 1; i < 5000; ++i) {
    const auto key = *KnownKey::from_private(
        kModp, Bytes{static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i), 7});
    const auto plain = *key.public_octets();
    ASSERT_NE(plain[0], 0);
    if (plain.size() == 256) continue;
    auto padded = plain;
    padded.insert(padded.begin(), 256 - plain.size(), 0);
    EXPECT_TRUE(PeerPublicKey::parse(kModp, plain));
    EXPECT_TRUE(PeerPublicKey::parse(kModp, padded));
    EXPECT_TRUE(PeerPublicKey::parse(kModp, der_of(plain)));
    return;
  }
  FAIL() << "no short value in 5000";
}

TEST(KeyAgreement, PrivateNumbersOutOfRange_AreRefused) {
  for (const auto kind : {kP256, kP384, kModp}) {
    EXPECT_CODE(KnownKey::from_private(kind, Bytes{0}), public_key_not_in_group);
    EXPECT_CODE(KnownKey::from_private(kind, Bytes(300, 0xff)), public_key_not_in_group);
  }
}

}  // namespace
}  // namespace ddssec::pki
