// The locators of many readers, with each locator listed once.
#pragma once

#include <map>

#include "wire/locator.hpp"

namespace ddssec::rtps {

/// Counts the readers of each locator. Adding and removing one does not search the others.
class LocatorCounts {
 public:
  void add(const LocatorList& locators) {
    for (const auto& locator : locators) {
      const auto [at, is_new] = places_.try_emplace(locator, Place{all_.size()});
      if (is_new) all_.push_back(locator);
      ++at->second.count;
    }
  }
  /// The locators must have been added before.
  void remove(const LocatorList& locators) {
    for (const auto& locator : locators) {
      const auto at = places_.find(locator);
      if (--at->second.count > 0) continue;
      all_[at->second.index] = all_.back();
      places_.find(all_.back())->second.index = at->second.index;
      all_.pop_back();
      places_.erase(at);
    }
  }
  const LocatorList& all() const { return all_; }

 private:
  struct Place {
    std::size_t index;  ///< index in all_
    std::size_t count = 0;
  };
  LocatorList all_;
  std::map<Locator, Place> places_;
};

}  // namespace ddssec::rtps
