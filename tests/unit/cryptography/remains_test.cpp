// What a message leaves in memory after it is encrypted or decrypted: no key stream of its last
// block, and no session key, with each source of the ciphers.
#include "tests/support/remains.hpp"

#include <tuple>

#include <gtest/gtest.h>

#include "tests/unit/cryptography/two_sides.hpp"

namespace ddssec::cryptography::testing {
namespace {

using test::Remains;

constexpr std::size_t kHeader = 24;  // CryptoHeader and the length of the ciphertext
constexpr std::size_t kBlock = 16, kBlocks = 4, kPart = 15;

// Returns the key stream for the last, incomplete block of a payload.
Bytes last_stream(const Bytes& plain, const Bytes& encoded) {
  Bytes out(kPart);
  for (std::size_t i = 0; i < kPart; ++i) {
    const auto at = kBlocks * kBlock + i;
    out[i] = static_cast<std::uint8_t>(plain[at] ^ encoded[kHeader + at]);
  }
  return out;
}

class Leftovers : public ::testing::TestWithParam<std::tuple<AeadChoice, std::string_view>> {};
INSTANTIATE_TEST_SUITE_P(EachCipher, Leftovers,
                         ::testing::Combine(::testing::Values(AeadChoice::automatic,
                                                              AeadChoice::openssl),
                                            ::testing::Values(spi::kAes128Name, spi::kAes256Name,
                                                              spi::kChaCha20Poly1305Name)));

// In older releases of OpenSSL (3.0) a context keeps it beside its key, and wipes both in the end.
TEST_P(Leftovers, KeyStreamOfTheLastBlock_IsWiped) {
  const auto [aead, algorithm] = GetParam();
  auto two = std::make_unique<TwoSides>(ProtectionKind::none, cipher(algorithm),
                                        CryptographyOptions{.aead = aead});
  const auto e = two->endpoints(endpoint_attributes(ProtectionKind::none, ProtectionKind::encrypt),
                                cipher(algorithm), cipher(algorithm));
  Bytes plain(kBlocks * kBlock + kPart);
  for (std::size_t i = 0; i < plain.size(); ++i) plain[i] = static_cast<std::uint8_t>(i * 7 + 1);
  Bytes encoded, decoded;
  test::at_depth([&] { encoded = encode_payload(*two, e, plain).value(); });
  Remains remains;
  auto stream = last_stream(plain, encoded);
  remains.look_for("key stream", stream);
  wipe(stream);
  const bool may_keep_it = aead == AeadChoice::openssl;
  EXPECT_TRUE(may_keep_it || remains.find().empty());
  test::at_depth([&] { decoded = decode_payload(*two, e, encoded).value(); });
  EXPECT_TRUE(may_keep_it || remains.find().empty());
  EXPECT_EQ(decoded, plain);
  two.reset();
  EXPECT_EQ(remains.find(), std::vector<std::string>());
}

}  // namespace
}  // namespace ddssec::cryptography::testing
