// A reproducible random source.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include <sodium.h>

#include "base/clock.hpp"
#include "base/writer.hpp"

namespace ddssec {

/// A reproducible stream from a seed. Never use it for real keys.
class SeededRandom final : public Random {
 public:
  explicit SeededRandom(std::uint64_t seed) : seed_(seed) {}

  Status fill(MutableBytes out) override {
    Writer seed;
    seed.write(seed_);
    seed.write(counter_++);
    std::array<std::uint8_t, randombytes_SEEDBYTES> key{};
    std::ranges::copy(seed.view(), key.begin());
    randombytes_buf_deterministic(out.data(), out.size(), key.data());
    return {};
  }

 private:
  std::uint64_t seed_;
  std::uint64_t counter_ = 0;
};

}  // namespace ddssec
