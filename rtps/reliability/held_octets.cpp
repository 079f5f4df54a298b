#include "rtps/reliability/held_octets.hpp"

#include <algorithm>

#include "base/rollback.hpp"

namespace ddssec::rtps {

HeldOctets::Account::Account(HeldOctets& all, const GuidPrefix& identity, Holder* holder)
    : all_(all), share_(all.shares_.try_emplace(identity).first) {
  auto& parts = share_->second.parts;
  Rollback undo([&] {
    if (parts.empty()) all.shares_.erase(share_);
  });
  part_ = parts.try_emplace(holder).first;
  undo.release();
  ++part_->second.writers;
}

HeldOctets::Account::~Account() {
  release(octets_);
  auto& parts = share_->second.parts;
  if (--part_->second.writers == 0) parts.erase(part_);
  if (parts.empty()) all_.shares_.erase(share_);
}

void HeldOctets::Account::hold(std::size_t octets) {
  octets_ += octets;
  all_.octets_ += octets;
  share_->second.octets += octets;
  part_->second.octets += octets;
}

void HeldOctets::Account::release(std::size_t octets) {
  octets_ -= octets;
  all_.octets_ -= octets;
  share_->second.octets -= octets;
  part_->second.octets -= octets;
}

bool HeldOctets::exceeds_share(const GuidPrefix& identity) const {
  const auto share = shares_.find(identity);
  if (share == shares_.end()) return false;
  const auto own = share->second.octets;
  return own > limits_.of_one || own + octets_ > limits_.all;
}

void HeldOctets::trim(const GuidPrefix& identity, Holder& last) {
  if (!is_shared_) {
    while (const auto largest = largest_over_limit()) last.give_up_latest(*largest);
    return;
  }
  while (exceeds_share(identity)) {
    const auto& parts = shares_.find(identity)->second.parts;
    auto most = parts.find(&last);
    for (auto at = parts.begin(); at != parts.end(); ++at)
      if (most == parts.end() || at->second.octets > most->second.octets) most = at;
    if (most == parts.end() || most->second.octets == 0) return;
    most->first->give_up_latest(identity);
  }
}

std::optional<GuidPrefix> HeldOctets::largest_over_limit() const {
  const auto most =
      std::ranges::max_element(shares_, {}, [](const auto& share) { return share.second.octets; });
  if (most == shares_.end()) return std::nullopt;
  if (octets_ <= limits_.all && most->second.octets <= limits_.of_one) return std::nullopt;
  return most->first;
}

}  // namespace ddssec::rtps
