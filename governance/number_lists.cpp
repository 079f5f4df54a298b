#include "governance/number_lists.hpp"

#include <algorithm>

namespace ddssec::governance {
namespace {

std::uint64_t hash_of(std::span<const std::uint32_t> list) {
  std::uint64_t hash = 0x9E3779B97F4A7C15u + list.size();
  for (const auto number : list) {
    hash = (hash ^ number) * 0xD6E8FEB86659FD93u;
    hash ^= hash >> 32;
  }
  return hash;
}

}  // namespace

std::size_t NumberLists::slot_for(std::uint64_t hash, std::span<const std::uint32_t> list) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = hash & mask;
  for (; slots_[slot] != 0; slot = (slot + 1) & mask) {
    const Id id = slots_[slot] - 1;
    if (hashes_[id] == hash && std::ranges::equal((*this)[id], list)) break;
  }
  return slot;
}

void NumberLists::grow() {
  slots_.assign(slots_.size() * 2, 0);
  const std::size_t mask = slots_.size() - 1;
  for (Id id = 0; id < hashes_.size(); ++id) {
    std::size_t slot = hashes_[id] & mask;
    while (slots_[slot] != 0) slot = (slot + 1) & mask;
    slots_[slot] = id + 1;
  }
}

std::pair<NumberLists::Id, bool> NumberLists::add(std::span<const std::uint32_t> list) {
  const auto hash = hash_of(list);
  const auto slot = slot_for(hash, list);
  if (slots_[slot] != 0) return {slots_[slot] - 1, false};
  const auto id = static_cast<Id>(hashes_.size());
  slots_[slot] = id + 1;
  hashes_.push_back(hash);
  data_.insert(data_.end(), list.begin(), list.end());
  begin_.push_back(data_.size());
  if (hashes_.size() * 2 > slots_.size()) grow();
  return {id, true};
}

}  // namespace ddssec::governance
