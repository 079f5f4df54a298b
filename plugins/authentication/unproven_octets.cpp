#include "plugins/authentication/unproven_octets.hpp"

namespace ddssec::authentication {

std::optional<UnprovenOctets::Share> UnprovenOctets::take(const Sha256Digest& subject,
                                                          std::size_t octets,
                                                          std::size_t free_octets) {
  if (octets + free_octets <= kFreeOfAPeer) return Share(octets);
  const std::scoped_lock lock(mutex_);
  const auto known = by_subject_.find(subject);
  const auto of_subject = known == by_subject_.end() ? 0 : known->second;
  if (octets > kMostOfASubject - of_subject || octets > kMost - total_) return std::nullopt;
  by_subject_[subject] += octets;
  total_ += octets;
  return Share(*this, subject, octets);
}

void UnprovenOctets::give_back(const Sha256Digest& subject, std::size_t octets) noexcept {
  const std::scoped_lock lock(mutex_);
  const auto known = by_subject_.find(subject);
  if (known == by_subject_.end()) return;
  known->second -= octets;
  total_ -= octets;
  if (known->second == 0) by_subject_.erase(known);
}

}  // namespace ddssec::authentication
