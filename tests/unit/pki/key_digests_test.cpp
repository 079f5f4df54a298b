#include "pki/key_digests.hpp"

#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"
#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

Bytes encoded_key(const Certificate& certificate) {
  unsigned char* der = nullptr;
  const int size = i2d_X509_PUBKEY(X509_get_X509_PUBKEY(impl_of(certificate).x509.get()), &der);
  const OpensslMemoryPtr owner(der);
  return Bytes(der, der + size);
}

// Returns the digest that earlier versions logged.
std::string raw_digest(const Certificate& certificate) {
  return to_hex(sha256(encoded_key(certificate)));
}

// Returns a SubjectPublicKeyInfo that ends with 00 04 x y in the form that ends with 00 02 x or 00
// 03 x.
Bytes compressed(Bytes key, std::size_t width) {
  const auto point = key.size() - 2 * width - 1;
  key[point] = static_cast<std::uint8_t>(0x02 | (key.back() & 1));
  key.resize(point + 1 + width);
  for (const std::size_t length : {std::size_t{1}, point - 2})
    key[length] = static_cast<std::uint8_t>(key[length] - width);
  return key;
}

// Returns the same certificate with its point compressed. The signature does not count here.
Certificate compressed(const Certificate& certificate, std::size_t width) {
  const auto der = compressed(encoded_key(certificate), width);
  const auto* position = der.data();
  const PkeyPtr key(d2i_PUBKEY(nullptr, &position, static_cast<long>(der.size())));
  const X509Ptr x509(X509_dup(impl_of(certificate).x509.get()));
  EXPECT_EQ(X509_set_pubkey(x509.get(), key.get()), 1);
  EXPECT_GT(i2d_re_X509_tbs(x509.get(), nullptr), 0);  // encodes the new content
  unsigned char* octets = nullptr;
  const int size = i2d_X509(x509.get(), &octets);
  const OpensslMemoryPtr owner(octets);
  auto out = Certificate::from_der(BytesView(octets, static_cast<std::size_t>(size)));
  EXPECT_TRUE(out) << out.error().to_sentence();
  return *std::move(out);
}

class KeyDigest : public testing::TestWithParam<KeySpec> {};

TEST_P(KeyDigest, PublicKey_HasTheDigestThatEarlierVersionsLogged) {
  const auto leaf = make_leaf(make_ca(), "CN=a", GetParam()).certificate;
  EXPECT_EQ(key_digest(leaf), raw_digest(leaf));
  EXPECT_TRUE(KeyDigests(leaf).contains(raw_digest(leaf)));
  EXPECT_FALSE(KeyDigests(leaf).contains(""));
}

INSTANTIATE_TEST_SUITE_P(Kinds, KeyDigest,
                         testing::Values(KeySpec{KeyKind::ec_p256}, KeySpec{KeyKind::ec_p384},
                                         KeySpec{KeyKind::rsa, 2048}));

TEST(KeyDigest, BothEncodingsOfAnEcKey_HaveOneDigest) {
  for (const auto& [kind, width] : {std::pair{KeyKind::ec_p256, 32u}, {KeyKind::ec_p384, 48u}}) {
    const auto leaf = make_leaf(make_ca(), "CN=a", {kind}).certificate;
    const auto other = compressed(leaf, width);
    ASSERT_NE(raw_digest(other), raw_digest(leaf));
    EXPECT_EQ(key_digest(other), key_digest(leaf));
    // A digest that an earlier version logged for one encoding is known for the other one.
    EXPECT_TRUE(KeyDigests(leaf).contains(raw_digest(other)));
    EXPECT_TRUE(KeyDigests(other).contains(raw_digest(leaf)));
    EXPECT_FALSE(KeyDigests(leaf).contains(key_digest(make_leaf(make_ca()).certificate)));
  }
}

}  // namespace
}  // namespace ddssec::pki
