// Hashes, wiping and constant-time comparison, over OpenSSL and libsodium.
#pragma once

#include <array>
#include <cstdint>
#include <initializer_list>
#include <span>

#include "base/bytes.hpp"

namespace ddssec {

using Sha256Digest = std::array<std::uint8_t, 32>;
using Md5Digest = std::array<std::uint8_t, 16>;

/// Returns SHA-256 over the concatenation of `parts`.
Sha256Digest sha256(std::initializer_list<BytesView> parts);
inline Sha256Digest sha256(BytesView octets) { return sha256({octets}); }
/// Writes the digest directly to `out`, for a secret digest (see Secret::digest_of).
void sha256(std::initializer_list<BytesView> parts, std::span<std::uint8_t, 32> out);

/// Returns HMAC-SHA256 over the concatenation of `parts`.
Sha256Digest hmac_sha256(BytesView key, std::initializer_list<BytesView> parts);

/// Returns MD5. Use it only where RTPS demands it: KEY_HASH (9.6.4.8), signatures of content
/// filters, and digests of a publisher's writers. Ends the process if OpenSSL refuses MD5, as a
/// FIPS provider does.
Md5Digest md5(BytesView octets);

/// Overwrites with zeros. The compiler cannot optimize the call away.
void wipe(MutableBytes octets) noexcept;

/// True if both have the same length and octets. The time depends on the length only.
bool constant_time_equal(BytesView a, BytesView b) noexcept;

}  // namespace ddssec
