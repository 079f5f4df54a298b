// Keeps the erased nodes of a map for the next insertions.
#pragma once

#include <utility>
#include <vector>

namespace ddssec::rtps {

/// The spare nodes of one map: erase keeps the node, insert uses it again.
template <class Map>
class SpareNodes {
 public:
  static constexpr std::size_t kMax = 256;

  /// Inserts a key that is not in the map yet. Returns its value.
  typename Map::mapped_type& insert(Map& map, const typename Map::key_type& key) {
    if (spare_.empty()) return map[key];
    auto node = std::move(spare_.back());
    spare_.pop_back();
    node.key() = key;
    return map.insert(std::move(node)).position->second;
  }
  /// Returns the iterator after `at`.
  typename Map::iterator erase(Map& map, typename Map::iterator at) {
    const auto next = std::next(at);
    auto node = map.extract(at);
    if (spare_.size() < kMax) {
      node.mapped() = {};
      spare_.push_back(std::move(node));
    }
    return next;
  }

 private:
  std::vector<typename Map::node_type> spare_;
};

}  // namespace ddssec::rtps
