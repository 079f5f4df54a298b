#include "rtps/memory/open_offers.hpp"

#include <algorithm>

namespace ddssec::rtps::memory {

MemoryResult<void> OpenOffers::add(Offer offer) {
  const std::lock_guard held(lock_);
  const auto of_one = std::ranges::count(offers_, offer.identity, &Offer::identity);
  if (offers_.size() >= kMax || of_one >= static_cast<std::ptrdiff_t>(kMaxOfOne))
    return refuse(MemoryRefusal::too_many_tokens);
  offers_.push_back(std::move(offer));
  return {};
}

void OpenOffers::withdraw(std::uint64_t segment) {
  const std::lock_guard held(lock_);
  std::erase_if(offers_, [&](const Offer& offer) { return offer.segment == segment; });
}

void OpenOffers::forget_late(MonotonicTime now) {
  const std::lock_guard held(lock_);
  std::erase_if(offers_, [&](const Offer& offer) { return offer.until <= now; });
}

std::optional<MonotonicTime> OpenOffers::next_end() const {
  const std::lock_guard held(lock_);
  std::optional<MonotonicTime> out;
  for (const auto& offer : offers_) out = out ? std::min(*out, offer.until) : offer.until;
  return out;
}

FileDescriptor OpenOffers::redeem(const Token& token) {
  const std::lock_guard held(lock_);
  std::size_t found = offers_.size();
  for (std::size_t i = 0; i < offers_.size(); ++i)
    if (offers_[i].token == token) found = i;
  if (found == offers_.size()) return FileDescriptor();
  auto out = std::move(offers_[found].descriptor);
  offers_.erase(offers_.begin() + static_cast<std::ptrdiff_t>(found));
  return out;
}

std::size_t OpenOffers::size() const {
  const std::lock_guard held(lock_);
  return offers_.size();
}

}  // namespace ddssec::rtps::memory
