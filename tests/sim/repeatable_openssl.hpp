// Gives OpenSSL a generator that repeats itself, so that a seed makes the same octets again.
#pragma once

#include <cstdint>

namespace ddssec::rtps::sim {

/// From now on every key, signature and Diffie-Hellman pair of this process follows from `seed`.
void make_openssl_repeatable(std::uint64_t seed);

}  // namespace ddssec::rtps::sim
