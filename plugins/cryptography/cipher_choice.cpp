#include "plugins/cryptography/cipher_choice.hpp"

#include "plugins/spi/property_names.hpp"

namespace ddssec::cryptography {
namespace {

std::unexpected<Error> invalid_property_error(std::string_view property, std::string expected,
                                              const std::string& found) {
  return fail(Code::invalid_property, {.field = std::string(property),
                                       .expected = std::move(expected),
                                       .found = found.substr(0, 64)});
}

// Returns the AES variant that `dds.sec.crypto.keysize` requests. This property is older than the
// names below.
Result<std::optional<Cipher>> aes_by_size(const spi::PropertyList& properties) {
  const auto* const value = spi::find_property(properties, spi::property::kKeySize);
  if (value == nullptr) return std::nullopt;
  if (*value == "128") return Cipher::aes128_gcm;
  if (*value == "256") return Cipher::aes256_gcm;
  return invalid_property_error(spi::property::kKeySize, "128 or 256", *value);
}

// Returns the cipher that a property names; empty for AUTO and for a missing property.
Result<std::optional<Cipher>> cipher_by_name(const spi::PropertyList& properties,
                                             std::string_view property) {
  const auto* const value = spi::find_property(properties, property);
  if (value == nullptr || *value == "AUTO") return std::nullopt;
  const auto asked = spi::cipher_of(*value);
  for (const auto cipher : {Cipher::aes128_gcm, Cipher::aes256_gcm, Cipher::chacha20_poly1305})
    if (asked == bit_of(cipher)) return cipher;
  return invalid_property_error(property, "AUTO or one of " + spi::names_of(spi::kAllCiphers),
                                *value);
}

}  // namespace

spi::CipherMask bit_of(Cipher cipher) {
  if (cipher == Cipher::chacha20_poly1305) return spi::kChaCha20Poly1305Bit;
  return cipher == Cipher::aes128_gcm ? spi::kAes128Bit : spi::kAes256Bit;
}

spi::CipherMask ciphers_of(const AeadBackend& backend) {
  const bool chacha = backend.has(Cipher::chacha20_poly1305);
  return chacha ? spi::kAllCiphers : spi::kStandardCiphers;
}

Result<std::optional<Cipher>> cipher_asked(const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto by_size, aes_by_size(properties));
  DDSSEC_ASSIGN_OR_RETURN(const auto by_name,
                          cipher_by_name(properties, spi::property::kSymmetricCipher));
  if (!by_name) return by_size;
  if (by_size && *by_name != Cipher::chacha20_poly1305 && by_name != by_size) {
    std::string expected("what ");
    expected.append(spi::property::kKeySize).append(" says");
    return invalid_property_error(spi::property::kSymmetricCipher, std::move(expected),
                                  spi::names_of(bit_of(*by_name)));
  }
  return by_name;
}

Result<ParticipantCiphers> participant_ciphers(const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto cipher, cipher_asked(properties));
  const auto endpoint = cipher.value_or(Cipher::aes256_gcm);
  auto message = endpoint;
  // All participants of a domain hear messages, so they use ChaCha20-Poly1305 only on request.
  if (endpoint == Cipher::chacha20_poly1305) {
    DDSSEC_ASSIGN_OR_RETURN(const auto aes, aes_by_size(properties));
    message = aes.value_or(Cipher::aes256_gcm);
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto asked,
                          cipher_by_name(properties, spi::property::kMessageCipher));
  return ParticipantCiphers{asked.value_or(message), endpoint};
}

Result<Cipher> pre_shared_cipher(const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto asked, cipher_by_name(properties, spi::property::kPskCipher));
  return asked.value_or(Cipher::aes256_gcm);
}

Status check_peer(Cipher cipher, spi::CipherMask peer) {
  if ((peer & bit_of(cipher)) != 0) return {};
  return fail(Code::cipher_not_understood_by_peer, {.field = "symmetric cipher",
                                                    .expected = spi::names_of(bit_of(cipher)),
                                                    .found = spi::names_of(peer)});
}

}  // namespace ddssec::cryptography
