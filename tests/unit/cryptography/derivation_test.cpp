// Derived keys, computed a second time from the text of the standard.
#include "plugins/cryptography/derivation.hpp"

#include <gtest/gtest.h>

#include "base/hash.hpp"

namespace ddssec::cryptography {
namespace {

template <class Key>
Bytes octets_of(const Key& key) {
  return key.expose([](BytesView octets) { return to_bytes(octets); });
}

Bytes joined(std::initializer_list<BytesView> parts) {
  Bytes out;
  for (const auto part : parts) out.insert(out.end(), part.begin(), part.end());
  return out;
}

Bytes first_of(const Sha256Digest& digest, std::size_t size) {
  return {digest.begin(), digest.begin() + static_cast<std::ptrdiff_t>(size)};
}

constexpr SessionId kSession{{0x01, 0x02, 0x03, 0x04}};

// DDS-Security 1.2, clause 10.5.3.3.3.
TEST(SessionKey, EachSession_HasTheHmacOfLabelSaltAndSession) {
  for (const std::size_t size : {16u, 32u}) {
    const Bytes key(size, 0x11), salt(size, 0x22);
    const auto label = as_bytes("SessionKey");
    const auto derived = derive_session_key(MasterKey::copy_of(key).value(),
                                            MasterSalt::copy_of(salt).value(), kSession);
    EXPECT_EQ(octets_of(derived),
              first_of(hmac_sha256(key, {joined({label, salt, kSession.view()})}), size));
  }
}

TEST(SessionReceiverKey, SameSession_GivesAnotherKeyThanTheSenders) {
  const Bytes key(32, 0x11), salt(32, 0x22);
  const auto master_salt = MasterSalt::copy_of(salt).value();
  const auto derived =
      derive_session_receiver_key(MasterReceiverKey::copy_of(key).value(), master_salt, kSession);
  const auto label = as_bytes("SessionReceiverKey");
  EXPECT_EQ(octets_of(derived),
            first_of(hmac_sha256(key, {joined({label, salt, kSession.view()})}), 32));
  EXPECT_NE(octets_of(derived),
            octets_of(derive_session_key(MasterKey::copy_of(key).value(), master_salt, kSession)));
}

TEST(SessionKey, EachInput_Counts) {
  const auto derived = [](std::uint8_t key, std::uint8_t salt, SessionId session) {
    return octets_of(derive_session_key(MasterKey::copy_of(Bytes(32, key)).value(),
                                        MasterSalt::copy_of(Bytes(32, salt)).value(), session));
  };
  const auto usual = derived(1, 2, kSession);
  EXPECT_EQ(derived(1, 2, kSession), usual);
  EXPECT_NE(derived(3, 2, kSession), usual);
  EXPECT_NE(derived(1, 3, kSession), usual);
  EXPECT_NE(derived(1, 2, SessionId{{0x01, 0x02, 0x03, 0x05}}), usual);
}

// DDS-Security 1.2, clause 10.5.2.1.2.
TEST(KeyExchangeMaterial, SecretAndBothChallenges_GiveTheKeys) {
  spi::SharedSecret shared;
  const Bytes secret(32, 0x33);
  shared.secret = spi::SharedSecretOctets::copy_of(secret).value();
  shared.challenge1.fill(0x44);
  shared.challenge2.fill(0x55);
  const auto material = derive_key_exchange_material(shared);
  EXPECT_EQ(material.kind, kAes256Gcm);
  EXPECT_EQ(material.sender_key_id, KeyId{});
  const auto expected = [&](BytesView first, std::string_view cookie, BytesView second) {
    EXPECT_EQ(cookie.size(), 16u);
    return first_of(hmac_sha256(sha256(joined({first, as_bytes(cookie), second})), {secret}), 32);
  };
  EXPECT_EQ(octets_of(material.salt),
            expected(shared.challenge1, "keyexchange salt", shared.challenge2));
  EXPECT_EQ(octets_of(material.sender_key),
            expected(shared.challenge2, "key exchange key", shared.challenge1));
}

}  // namespace
}  // namespace ddssec::cryptography
