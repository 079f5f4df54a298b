#include "rtps/reliability/held_octets.hpp"

#include <algorithm>

namespace ddssec::rtps {

HeldOctets::Account::Account(HeldOctets& all, const GuidPrefix& identity)
    : all_(all), share_(all.shares_.try_emplace(identity).first) {
  ++share_->second.writers;
}

HeldOctets::Account::~Account() {
  release(octets_);
  if (--share_->second.writers == 0) all_.shares_.erase(share_);
}

void HeldOctets::Account::hold(std::size_t octets) {
  octets_ += octets;
  all_.octets_ += octets;
  share_->second.octets += octets;
}

void HeldOctets::Account::release(std::size_t octets) {
  octets_ -= octets;
  all_.octets_ -= octets;
  share_->second.octets -= octets;
}

bool HeldOctets::exceeds_share(const GuidPrefix& identity) const {
  const auto share = shares_.find(identity);
  if (share == shares_.end()) return false;
  const auto own = share->second.octets;
  return own > limits_.of_one || own + octets_ > limits_.all;
}

std::optional<GuidPrefix> HeldOctets::largest_over_limit() const {
  const auto most =
      std::ranges::max_element(shares_, {}, [](const auto& share) { return share.second.octets; });
  if (most == shares_.end()) return std::nullopt;
  if (octets_ <= limits_.all && most->second.octets <= limits_.of_one) return std::nullopt;
  return most->first;
}

}  // namespace ddssec::rtps
