// AES-GCM and ChaCha20-Poly1305, for encrypting or for a MAC alone, behind one small interface with
// the implementation chosen at run time.
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
/// Octets.
constexpr std::size_t key_size_of(Cipher cipher) { return cipher == Cipher::aes128_gcm ? 16 : 32; }

/// 96 bits: session id, then suffix (DDS-Security 9.5.3.3.4).
using Iv = std::array<std::uint8_t, 12>;
inline constexpr std::size_t kTagSize = 16;
using TagView = std::span<const std::uint8_t, kTagSize>;
using TagOut = std::span<std::uint8_t, kTagSize>;

/// Octets an expanded key may take up, whatever the implementation.
inline constexpr std::size_t kKeyStorage = 1264;
using KeyStorage = std::byte*;

struct SealRequest {
  const Iv& iv;
  BytesView aad;
  BytesView plain;
  std::uint8_t* out;  ///< as many octets as `plain`; may be the same place, not overlap otherwise
  TagOut tag;
};

struct OpenRequest {
  const Iv& iv;
  BytesView aad;
  BytesView cipher;
  std::uint8_t* out;  ///< as many octets as `cipher`; may be the same place
  TagOut tag;         ///< receives the tag that the message should have
};

/// One implementation. Stateless, lives as long as the process. The storage of a key is aligned to
/// 64 octets and used by several threads at once, without `expand` and `destroy`.
class AeadBackend {
 public:
  virtual ~AeadBackend() = default;
  virtual std::string_view name() const = 0;
  /// Both sizes of AES-GCM always; the rest may be missing (a FIPS provider has no ChaCha20).
  virtual bool has(Cipher cipher) const = 0;

 protected:
  friend class ExpandedKey;
  virtual bool expand(KeyStorage storage, Cipher cipher, BytesView key) const = 0;
  virtual bool seal(KeyStorage storage, Cipher cipher, const SealRequest& request) const = 0;
  /// Decrypts and computes the tag; comparing and wiping are the caller's.
  virtual bool open(KeyStorage storage, Cipher cipher, const OpenRequest& request,
                    TagView expected) const = 0;
  /// Anything that is not plain octets; these are wiped by the caller.
  virtual void destroy(KeyStorage storage) const noexcept = 0;
};

/// Those that this build has and this processor can run, best first; never empty.
std::span<const AeadBackend* const> aead_backends();
/// The one asked for, or nullptr if it is not available here.
const AeadBackend* aead_backend(AeadChoice choice);

/// A cipher's key, expanded in its final place and wiped when it dies. Used by many
/// threads at once. About 1 KiB.
class alignas(64) ExpandedKey {
 public:
  ExpandedKey() = default;
  ~ExpandedKey() { clear(); }
  ExpandedKey(const ExpandedKey&) = delete;
  ExpandedKey& operator=(const ExpandedKey&) = delete;

  /// Replaces what was there. Errors: length_out_of_range, internal.
  Status expand(const AeadBackend& backend, Cipher cipher, BytesView key);
  bool empty() const { return backend_ == nullptr; }

  /// Encrypts `plain` to `out` (same size; the same place or disjoint) and writes the tag.
  [[nodiscard]] bool seal(const SealRequest& request) const;
  /// Decrypts if the tag is right. Otherwise `out` holds zeros and the result is false.
  [[nodiscard]] bool open(const Iv& iv, BytesView aad, BytesView cipher, std::uint8_t* out,
                          TagView tag) const;
  /// The tag over `data`, nothing encrypted (GMAC, or Poly1305 by the same construction).
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
