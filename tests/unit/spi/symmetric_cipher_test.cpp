#include "plugins/spi/symmetric_cipher.hpp"

#include <gtest/gtest.h>

namespace ddssec::spi {
namespace {

TEST(SymmetricCipher, NamesAndBits_BelongTogether) {
  for (const auto bit : {kAes128Bit, kAes256Bit, kChaCha20Poly1305Bit})
    EXPECT_EQ(cipher_of(names_of(bit)), bit);
  EXPECT_EQ(names_of(kAllCiphers), "AES128+GCM,AES256+GCM,org.ddssec.ChaCha20-Poly1305");
  EXPECT_EQ(names_of(0), "none");
  EXPECT_EQ(names_of(0x00020000), "none");
  for (const auto* const unknown : {"", "AUTO", "aes128+gcm", "AES128+GCM,", "none"})
    EXPECT_EQ(cipher_of(unknown), std::nullopt) << unknown;
}

TEST(SymmetricCipher, AList_MayNameUnknownCiphers) {
  EXPECT_EQ(ciphers_in(names_of(kAllCiphers)), kAllCiphers);
  EXPECT_EQ(ciphers_in("com.example.X,org.ddssec.ChaCha20-Poly1305,"), kChaCha20Poly1305Bit);
  for (const auto* const nothing : {"", ",", ",,", "none", " AES128+GCM", "AES128+GCM AES256+GCM"})
    EXPECT_EQ(ciphers_in(nothing), 0u) << nothing;
}

// DDS-Security 1.2, clause 7.3.9.
TEST(SymmetricCipher, PeersCiphers_MustHoldAllOrInCompatibilityModeAny) {
  constexpr CipherMask kCompatible = CipherMask{1} << 31;
  EXPECT_TRUE(is_supported_by(0x2, 0x3));
  EXPECT_TRUE(is_supported_by(0x0, 0x3));
  EXPECT_FALSE(is_supported_by(0x3, 0x2));
  EXPECT_FALSE(is_supported_by(kChaCha20Poly1305Bit, kStandardCiphers));
  EXPECT_TRUE(is_supported_by(kCompatible | 0x3, 0x2));
  EXPECT_FALSE(is_supported_by(kCompatible | 0x3, 0x4));
}

}  // namespace
}  // namespace ddssec::spi
