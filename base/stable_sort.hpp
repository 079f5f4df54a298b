// Stable sorting. std::stable_sort does not compile with clang 19 on g++ 12's library when warnings
// are errors, because it calls functions that C++17 deprecates.
#pragma once

#include <algorithm>
#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

namespace ddssec {

/// Sorts by key_of(item) in ascending order; equal items keep their order. Copies the keys and
/// allocates a second list.
template <class T, class KeyOf>
void stable_sort_by(std::vector<T>& items, KeyOf&& key_of) {
  using Key = std::decay_t<decltype(std::invoke(key_of, items.front()))>;
  std::vector<std::pair<Key, std::size_t>> order;
  order.reserve(items.size());
  for (const auto& item : items) order.emplace_back(std::invoke(key_of, item), order.size());
  std::ranges::sort(order);
  std::vector<T> sorted;
  sorted.reserve(items.size());
  for (const auto& [key, index] : order) sorted.push_back(std::move(items[index]));
  items = std::move(sorted);
}

/// Sorts in descending order; equal items keep their order.
template <class T, class KeyOf>
void stable_sort_descending_by(std::vector<T>& items, KeyOf&& key_of) {
  std::ranges::reverse(items);
  stable_sort_by(items, std::forward<KeyOf>(key_of));
  std::ranges::reverse(items);
}

}  // namespace ddssec
