// A reproducible random source for tests. Not installed.
#pragma once

#include "base/clock.hpp"

namespace ddssec {

/// A reproducible stream from a seed. Never use it for real keys.
class SeededRandom final : public Random {
 public:
  explicit SeededRandom(std::uint64_t seed) : seed_(seed) {}
  Status fill(MutableBytes out) override;

 private:
  std::uint64_t seed_;
  std::uint64_t counter_ = 0;
};

}  // namespace ddssec
