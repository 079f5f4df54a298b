#include "plugins/cryptography/fragmented_tokens.hpp"

#include <algorithm>

namespace ddssec::cryptography {

void FragmentedTokens::note(std::uint64_t number) {
  const std::lock_guard lock(mutex_);
  if (std::ranges::find(numbers_, number) != numbers_.end()) return;
  if (numbers_.size() < kMax) return numbers_.push_back(number);
  numbers_[oldest_] = number;
  oldest_ = (oldest_ + 1) % kMax;
}

bool FragmentedTokens::contains(std::uint64_t number) const {
  const std::lock_guard lock(mutex_);
  return std::ranges::find(numbers_, number) != numbers_.end();
}

}  // namespace ddssec::cryptography
