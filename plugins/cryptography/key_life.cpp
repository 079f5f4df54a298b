#include "plugins/cryptography/key_life.hpp"

#include "plugins/cryptography/key_revision.hpp"

namespace ddssec::cryptography {
namespace {

// Returns a value from three quarters of the limit to the whole limit.
std::uint64_t in_last_quarter(std::uint64_t limit, std::uint64_t chance) {
  return limit - chance % (limit / 4 + 1);
}

}  // namespace

// The new keys must be in use, and the former ones must be invalid, when the lifetime is over.
void KeyLife::begin(std::chrono::nanoseconds now, std::uint64_t chance) {
  const auto whole = static_cast<std::uint64_t>(std::chrono::nanoseconds(limits_.lifetime).count());
  const std::chrono::nanoseconds drawn{in_last_quarter(whole, chance)};
  earliest_ = now + kFormerKeyLife;
  end_ = now + drawn - kFormerKeyLife - kAsked;
  last_block_ = in_last_quarter(limits_.blocks, chance);
}

bool KeyLife::has_ended(std::chrono::nanoseconds now) const {
  return limits_.lifetime.count() != 0 && now >= end_;
}

bool KeyLife::counts_blocks(std::chrono::nanoseconds now) const {
  return limits_.blocks != 0 && now >= earliest_;
}

}  // namespace ddssec::cryptography
