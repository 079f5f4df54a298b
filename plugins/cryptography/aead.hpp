// AES-GCM and ChaCha20-Poly1305, for encryption or for a MAC alone. One small interface; the
// implementation is chosen at run time.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/cryptography.hpp"

namespace ddssec::cryptography {

enum class Cipher : std::uint8_t { aes128_gcm, aes256_gcm, chacha20_poly1305 };
/// Returns the key size in octets.
constexpr std::size_t key_size_of(Cipher cipher) { return cipher == Cipher::aes128_gcm ? 16 : 32; }

/// The initialization vector, 96 bits: session id, then suffix (DDS-Security 1.2,
/// clause 10.5.3.3.4).
using Iv = std::array<std::uint8_t, 12>;
inline constexpr std::size_t kTagSize = 16;
using TagView = std::span<const std::uint8_t, kTagSize>;
using TagOut = std::span<std::uint8_t, kTagSize>;

/// The largest size of an expanded key of any implementation, in octets.
inline constexpr std::size_t kKeyStorage = 1264;
using KeyStorage = std::byte*;

/// What is encrypted or authenticated. An IV must never be used twice with a key.
struct SealRequest {
  const Iv& iv;
  BytesView aad;
  BytesView plain;
  std::uint8_t* out;  ///< as many octets as `plain`; the same place or disjoint
  TagOut tag;
};

/// What is decrypted or verified. The caller compares the tag before it uses `out`.
struct OpenRequest {
  const Iv& iv;
  BytesView aad;
  BytesView cipher;
  std::uint8_t* out;  ///< as many octets as `cipher`; the same place or disjoint
  TagOut tag;         ///< receives the computed tag
};

/// An implementation. It is stateless and lives as long as the process. The storage of a key is
/// aligned to 64 octets. Several threads use it at once, except during `expand` and `destroy`.
class AeadBackend {
 public:
  virtual ~AeadBackend() = default;
  virtual std::string_view name() const = 0;
  /// True for both key sizes of AES-GCM; other ciphers may be missing (a FIPS provider has no
  /// ChaCha20).
  virtual bool has(Cipher cipher) const = 0;

 protected:
  friend class ExpandedKey;
  virtual bool expand(KeyStorage storage, Cipher cipher, BytesView key) const = 0;
  virtual bool seal(KeyStorage storage, Cipher cipher, const SealRequest& request) const = 0;
  /// Decrypts and computes the tag. The caller compares the tag and wipes `out`.
  virtual bool open(KeyStorage storage, Cipher cipher, const OpenRequest& request,
                    TagView expected) const = 0;
  /// Frees objects in the storage. The caller wipes the octets.
  virtual void destroy(KeyStorage storage) const noexcept = 0;
};

/// Returns the implementations that this build contains and this processor can run, best first;
/// never empty.
std::span<const AeadBackend* const> aead_backends();
/// Returns the requested implementation; nullptr if it is not available.
const AeadBackend* aead_backend(AeadChoice choice);

/// A cipher's key, expanded in its final place and wiped at destruction. Many threads may use it at
/// once. Its size is about 1 KiB.
class alignas(64) ExpandedKey {
 public:
  ExpandedKey() = default;
  ~ExpandedKey() { clear(); }
  ExpandedKey(const ExpandedKey&) = delete;
  ExpandedKey& operator=(const ExpandedKey&) = delete;

  /// Replaces the key. No other thread may use it meanwhile. Errors: length_out_of_range, internal.
  Status expand(const AeadBackend& backend, Cipher cipher, BytesView key);
  bool empty() const { return backend_ == nullptr; }

  /// Encrypts `plain` to `out` (same size; the same place or disjoint) and writes the tag. False if
  /// the implementation fails.
  [[nodiscard]] bool seal(const SealRequest& request) const;
  /// Decrypts if the tag is right. Otherwise `out` holds zeros and the result is false.
  [[nodiscard]] bool open(const Iv& iv, BytesView aad, BytesView cipher, std::uint8_t* out,
                          TagView tag) const;
  /// Writes the tag over `data` without encrypting anything (GMAC, or Poly1305 by the same
  /// construction). False if the implementation fails.
  [[nodiscard]] bool mac(const Iv& iv, BytesView data, TagOut tag) const;
  /// True if `tag` is the MAC over `data`; the time does not depend on the tags.
  [[nodiscard]] bool verify(const Iv& iv, BytesView data, TagView tag) const;

 private:
  void clear() noexcept;

  mutable std::array<std::byte, kKeyStorage> storage_;
  const AeadBackend* backend_ = nullptr;
  Cipher cipher_ = Cipher::aes256_gcm;
};

}  // namespace ddssec::cryptography
