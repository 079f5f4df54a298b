#include "pki/key_derivation.hpp"

#include <algorithm>

#include <openssl/pem.h>
#include <openssl/pkcs12.h>

#include "pki/openssl_pointers.hpp"
#include "pki/private_key.hpp"
#include "pki_fixture.hpp"

namespace ddssec::pki {
namespace {

using Pkcs8Ptr = std::unique_ptr<PKCS8_PRIV_KEY_INFO, Deleter<PKCS8_PRIV_KEY_INFO_free>>;
using EncryptedPtr = std::unique_ptr<X509_SIG, Deleter<X509_SIG_free>>;

constexpr std::string_view kPassphrase = "secret";

// Returns an encrypted key; `algorithm` is given to the key.
EncryptedPtr encrypted(X509_ALGOR* algorithm) {
  const PkeyPtr key(EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", "P-256"));
  const Pkcs8Ptr plain(EVP_PKEY2PKCS8(key.get()));
  return EncryptedPtr(PKCS8_set0_pbe(kPassphrase.data(), static_cast<int>(kPassphrase.size()),
                                     plain.get(), algorithm));
}

// Returns the text of the key, with other octets in place of those in its parameters.
std::string changed(const EncryptedPtr& key, Bytes from, Bytes to) {
  unsigned char* octets = nullptr;
  const int size = i2d_X509_SIG(key.get(), &octets);
  const OpensslMemoryPtr owner(octets);
  const std::span der(octets, static_cast<std::size_t>(size));
  const auto found = std::ranges::search(der, from);
  EXPECT_EQ(found.size(), from.size());
  EXPECT_EQ(from.size(), to.size());
  std::ranges::copy(to, found.begin());
  const BioPtr bio(BIO_new(BIO_s_mem()));
  PEM_write_bio(bio.get(), PEM_STRING_PKCS8, "", octets, size);
  char* text = nullptr;
  const long length = BIO_get_mem_data(bio.get(), &text);
  return {text, static_cast<std::size_t>(length)};
}

std::string with_iterations(std::uint32_t number) {
  static const auto key =
      encrypted(PKCS5_pbe2_set_iv(EVP_aes_256_cbc(), 0x10000, nullptr, 0, nullptr, -1));
  const auto octet = [&](int shift) { return static_cast<std::uint8_t>(number >> shift); };
  return changed(key, {2, 3, 1, 0, 0}, {2, 3, octet(16), octet(8), octet(0)});
}

Status check(std::string_view pem) { return check_key_derivation(as_bytes(pem)); }

TEST(KeyDerivation, MoreIterationsThanTheLimit_AreRefused) {
  ASSERT_OK(check(with_iterations(0x10000)));
  ASSERT_OK(check(with_iterations(kMaxIterations)));
  const auto refused = check(with_iterations(kMaxIterations + 1));
  EXPECT_CODE(refused, key_not_allowed);
  EXPECT_EQ(refused.error().details().found, "5000001");
  EXPECT_CODE(check(with_iterations(0x800000)), key_not_allowed);  // a negative number
}

TEST(KeyDerivation, ScryptThatCostsMoreThanTheLimit_IsRefused) {
  const auto key =
      encrypted(PKCS5_pbe2_set_scrypt(EVP_aes_256_cbc(), nullptr, 0, nullptr, 1024, 8, 1));
  const Bytes usual{2, 2, 4, 0, 2, 1, 8, 2, 1, 1};
  ASSERT_OK(check(changed(key, usual, usual)));
  ASSERT_OK(check(changed(key, usual, {2, 2, 0x40, 0, 2, 1, 8, 2, 1, 64})));
  EXPECT_CODE(check(changed(key, usual, {2, 2, 0x40, 0, 2, 1, 8, 2, 1, 65})), key_not_allowed);
}

TEST(KeyDerivation, FormerAlgorithms_HaveTheLimitToo) {
  const auto key =
      encrypted(PKCS5_pbe_set(NID_pbe_WithSHA1And3_Key_TripleDES_CBC, 0x10000, nullptr, 0));
  ASSERT_OK(check(changed(key, {2, 3, 1, 0, 0}, {2, 3, 1, 0, 0})));
  EXPECT_CODE(check(changed(key, {2, 3, 1, 0, 0}, {2, 3, 0x7f, 0, 0})), key_not_allowed);
}

TEST(KeyDerivation, EachKeyOfAFile_IsChecked) {
  const auto costly = with_iterations(kMaxIterations + 1);
  const auto plain = PrivateKey::generate(KeyKind::ec_p256)->to_pem()->expose([](BytesView octets) {
    return std::string(as_text(octets));
  });
  EXPECT_CODE(check(with_iterations(2 << 16) + costly), key_not_allowed);
  EXPECT_CODE(check(plain + "text\n" + costly), key_not_allowed);
  ASSERT_OK(check(plain));
  ASSERT_OK(check("no key"));
  ASSERT_OK(check(""));
}

TEST(KeyDerivation, AKeyThatIsEncryptedTwice_IsRefused) {
  auto twice = with_iterations(0x10000);
  twice.insert(
      twice.find('\n') + 1,
      "Proc-Type: 4,ENCRYPTED\nDEK-Info: AES-256-CBC,00112233445566778899AABBCCDDEEFF\n\n");
  EXPECT_CODE(check(twice), private_key_malformed);
}

TEST(KeyDerivation, PrivateKey_TriesNoPassphraseOfSuchAKey) {
  const auto passphrase = *Passphrase::copy_of(as_bytes(kPassphrase));
  ASSERT_OK(PrivateKey::from_pem(as_bytes(with_iterations(0x10000)), &passphrase));
  EXPECT_CODE(PrivateKey::from_pem(as_bytes(with_iterations(0x7fffff)), &passphrase),
              key_not_allowed);
  EXPECT_CODE(PrivateKey::from_pem(as_bytes(with_iterations(0x7fffff))), passphrase_missing);
}

}  // namespace
}  // namespace ddssec::pki
