// Remembers verdicts for names, in bounded memory. For governance/ only.
#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

namespace ddssec::governance {

/// Keeps entries in two generations. When the younger is full it becomes the older, and the older
/// is dropped. Names that are asked for often stay. Thread-safe.
template <class Value>
class DecisionCache {
 public:
  /// The size of one generation; the cache has at most twice as many entries.
  static constexpr std::size_t kMaxPerGeneration = 2048;
  /// Longer keys, in octets, are not stored.
  static constexpr std::size_t kMaxKey = 1024;

  std::optional<Value> find(const std::string& key) {
    const std::lock_guard lock(mutex_);
    if (const auto entry = young_.find(key); entry != young_.end()) return entry->second;
    const auto entry = old_.find(key);
    if (entry == old_.end()) return std::nullopt;
    const Value value = entry->second;
    insert(key, value);
    return value;
  }

  void remember(const std::string& key, Value value) {
    if (key.size() > kMaxKey) return;
    const std::lock_guard lock(mutex_);
    insert(key, std::move(value));
  }

  std::size_t size() {
    const std::lock_guard lock(mutex_);
    return young_.size() + old_.size();
  }

 private:
  void insert(const std::string& key, Value value) {
    if (young_.size() >= kMaxPerGeneration) {
      old_ = std::move(young_);
      young_.clear();
    }
    young_.insert_or_assign(key, std::move(value));
  }

  std::mutex mutex_;
  std::unordered_map<std::string, Value> young_, old_;
};

}  // namespace ddssec::governance
