// Orders lists of differences: the most worrying first, else as they were found.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace ddssec::governance {

/// Sorts by key_of(item), greatest first; equal ones keep their order. (The library's own stable
/// sort does not compile with clang 19 on this compiler's library when warnings are errors.)
template <class T, class KeyOf>
void order_by_greatest(std::vector<T>& items, KeyOf&& key_of) {
  using Key = decltype(key_of(items.front()));
  std::vector<std::pair<Key, std::size_t>> order;
  for (const auto& item : items) order.emplace_back(key_of(item), items.size() - order.size());
  std::ranges::sort(order, std::greater());
  std::vector<T> sorted;
  sorted.reserve(items.size());
  for (const auto& [key, from_end] : order) {
    sorted.push_back(std::move(items[items.size() - from_end]));
  }
  items = std::move(sorted);
}

}  // namespace ddssec::governance
