#include "plugins/authentication/adjusted_guid.hpp"

#include <algorithm>
#include <array>

namespace ddssec::authentication {
namespace {

constexpr std::size_t kHalf = 6;

std::array<std::uint8_t, kHalf> subject_half(const Sha256Digest& digest) {
  std::array<std::uint8_t, kHalf> half{};
  unsigned carry = 1;
  for (std::size_t i = 0; i < kHalf; ++i) {
    half[i] = static_cast<std::uint8_t>((carry << 7) | (digest[i] >> 1));
    carry = digest[i] & 1u;
  }
  return half;
}

}  // namespace

Guid adjusted_guid(const Sha256Digest& subject_digest, const Guid& candidate) {
  const auto octets = candidate.octets();
  const Sha256Digest own_half = sha256(octets);
  Guid adjusted{{}, candidate.entity};
  std::ranges::copy(subject_half(subject_digest), adjusted.prefix.octets.begin());
  std::copy_n(own_half.begin(), kHalf, adjusted.prefix.octets.begin() + kHalf);
  return adjusted;
}

bool is_bound_to(const Guid& guid, const Sha256Digest& subject_digest) {
  const auto half = subject_half(subject_digest);
  return std::equal(half.begin(), half.end(), guid.prefix.octets.begin());
}

bool is_adjusted(const Guid& guid) { return (guid.prefix.octets[0] & 0x80u) != 0; }

}  // namespace ddssec::authentication
