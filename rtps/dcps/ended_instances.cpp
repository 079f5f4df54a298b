#include "rtps/dcps/ended_instances.hpp"

#include <algorithm>

namespace ddssec::rtps {

std::vector<KeyHash> EndedInstances::add(const KeyHash& key, const GuidPrefix& identity,
                                         std::size_t octets) {
  remove(key);
  const auto price = octets + kPrice;
  auto& share = shares_[identity];
  share.oldest_first.push_back({key, price});
  share.octets += price;
  octets_ += price;
  places_[key] = {identity, std::prev(share.oldest_first.end())};
  std::vector<KeyHash> out;
  while (shares_.contains(identity) && shares_[identity].octets > kMaxOctetsPerIdentity)
    out.push_back(take_oldest(identity));
  while (octets_ > kMaxOctets) out.push_back(take_oldest(largest()));
  return out;
}

void EndedInstances::remove(const KeyHash& key) {
  const auto place = places_.find(key);
  if (place == places_.end()) return;
  const auto share = shares_.find(place->second.identity);
  const auto price = place->second.at->price;
  share->second.octets -= price;
  octets_ -= price;
  share->second.oldest_first.erase(place->second.at);
  if (share->second.oldest_first.empty()) shares_.erase(share);
  places_.erase(place);
}

std::vector<KeyHash> EndedInstances::take_all() {
  std::vector<KeyHash> out;
  for (const auto& [key, place] : places_) out.push_back(key);
  shares_.clear();
  places_.clear();
  octets_ = 0;
  return out;
}

KeyHash EndedInstances::take_oldest(const GuidPrefix& identity) {
  const auto key = shares_.at(identity).oldest_first.front().key;
  remove(key);
  return key;
}

GuidPrefix EndedInstances::largest() const {
  return std::ranges::max_element(shares_, {},
                                  [](const auto& entry) { return entry.second.octets; })
      ->first;
}

}  // namespace ddssec::rtps
