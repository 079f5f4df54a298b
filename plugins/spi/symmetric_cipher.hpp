// Symmetric ciphers as discovery and properties name them (DDS-Security 1.2, clauses 7.3.8
// and 8.1).
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
/// The ciphers that every DDS-Security participant supports, announced or not.
inline constexpr CipherMask kStandardCiphers = kAes128Bit | kAes256Bit;
/// A bit from the vendor-specific range. It has this meaning only for peers that are identified by
/// other means.
inline constexpr CipherMask kChaCha20Poly1305Bit = 0x00010000;
inline constexpr CipherMask kAllCiphers = kStandardCiphers | kChaCha20Poly1305Bit;

/// The values of `dds.sec.crypto.symmetric_cipher_algorithm` except AUTO.
inline constexpr std::string_view kAes128Name = "AES128+GCM";
inline constexpr std::string_view kAes256Name = "AES256+GCM";
inline constexpr std::string_view kChaCha20Poly1305Name = "org.ddssec.ChaCha20-Poly1305";

/// Returns the bit of the cipher with that name; empty if the name is unknown.
std::optional<CipherMask> cipher_of(std::string_view name);

/// Returns the names of the known ciphers in `mask`, separated by commas; "none" if there are none.
std::string names_of(CipherMask mask);
/// Returns the ciphers named in such a list; unknown names are skipped.
CipherMask ciphers_in(std::string_view names);

/// The announcement of a participant about its symmetric ciphers
/// (PID_PARTICIPANT_SECURITY_SYMMETRIC_CIPHER_ALGORITHM_INFO). A receiver must support the ciphers
/// of a `required` mask to decrypt this participant's traffic.
struct SymmetricCipherInfo {
  CipherMask supported = kStandardCiphers;
  CipherMask builtin_required = kAes256Bit;
  CipherMask key_exchange_required = kAes256Bit;
  CipherMask user_default_required = kAes256Bit;
  bool operator==(const SymmetricCipherInfo&) const = default;
};

/// True if all required ciphers are supported; in compatibility mode, any one of them suffices
/// (DDS-Security 1.2, clause 7.3.9).
constexpr bool is_supported_by(CipherMask required, CipherMask supported) {
  constexpr CipherMask kCompatibilityMode = CipherMask{1} << 31;
  if ((required & kCompatibilityMode) != 0) return (supported & required) != 0;
  return (supported & required) == required;
}

}  // namespace ddssec::spi
