// Symmetric ciphers as discovery and properties name them (DDS-Security 1.2 7.3.8, 8.1).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ddssec::spi {

/// A set of CryptoAlgorithmBits.
using CipherMask = std::uint32_t;

inline constexpr CipherMask kAes128Bit = 0x00000001;
inline constexpr CipherMask kAes256Bit = 0x00000002;
/// What every participant of DDS-Security has, announced or not.
inline constexpr CipherMask kStandardCiphers = kAes128Bit | kAes256Bit;
/// From the range that is left to vendors: has this meaning only for peers known by other means.
inline constexpr CipherMask kChaCha20Poly1305Bit = 0x00010000;
inline constexpr CipherMask kAllCiphers = kStandardCiphers | kChaCha20Poly1305Bit;

/// The values of `dds.sec.crypto.symmetric_cipher_algorithm` but for AUTO.
inline constexpr std::string_view kAes128Name = "AES128+GCM";
inline constexpr std::string_view kAes256Name = "AES256+GCM";
inline constexpr std::string_view kChaCha20Poly1305Name = "org.ddssec.ChaCha20-Poly1305";

/// The cipher of that name, or nothing.
std::optional<CipherMask> cipher_of(std::string_view name);

/// The names of those in `mask` that we know, with a comma between; "none" of none.
std::string names_of(CipherMask mask);
/// The ciphers named in such a list; what we do not know is passed over.
CipherMask ciphers_in(std::string_view names);

/// What a participant announces of its symmetric ciphers (PID_PARTICIPANT_SECURITY_SYMMETRIC_
/// CIPHER_ALGORITHM_INFO). A required mask names what has to be supported to understand it.
struct SymmetricCipherInfo {
  CipherMask supported = kStandardCiphers;
  CipherMask builtin_required = kAes256Bit;
  CipherMask key_exchange_required = kAes256Bit;
  CipherMask user_default_required = kAes256Bit;
  bool operator==(const SymmetricCipherInfo&) const = default;
};

/// (supported & required) == required, or any of them in compatibility mode (7.3.9).
constexpr bool understands(CipherMask supported, CipherMask required) {
  constexpr CipherMask kCompatibilityMode = CipherMask{1} << 31;
  if ((required & kCompatibilityMode) != 0) return (supported & required) != 0;
  return (supported & required) == required;
}

}  // namespace ddssec::spi
