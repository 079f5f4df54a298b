#include "plugins/cyclonedds/resting_pairs.hpp"

#include <algorithm>

namespace ddssec::cyclonedds {

RestingPairs::Duration RestingPairs::failed(spi::IdentityHandle local, const Guid& remote,
                                            Duration now) {
  if (!pairs_.contains({local, remote}) && pairs_.size() >= kMost)
    pairs_.erase(
        std::ranges::min_element(pairs_, {}, [](const auto& entry) { return entry.second.until; }));
  auto& rest = pairs_[{local, remote}];
  const auto before = rest.failures++;
  rest.is_over = before == 0;
  rest.until = now;
  if (!rest.is_over) rest.until += kFirstRest * (1u << std::min(before - 1, kMostDoublings));
  return rest.until - now;
}

RestingPairs::Duration RestingPairs::remaining(spi::IdentityHandle local, const Guid& remote,
                                               Duration now) const {
  const auto known = pairs_.find({local, remote});
  if (known == pairs_.end() || known->second.is_over) return {};
  return std::max(known->second.until - now, Duration{});
}

std::vector<Guid> RestingPairs::take_rested(Duration now) {
  std::vector<Guid> out;
  for (auto& [pair, rest] : pairs_) {
    if (rest.is_over || rest.until > now) continue;
    rest.is_over = true;
    out.push_back(pair.second);
  }
  return out;
}

void RestingPairs::forget_local(spi::IdentityHandle local) {
  std::erase_if(pairs_, [&](const auto& entry) { return entry.first.first == local; });
}

std::string minutes_in(RestingPairs::Duration time) {
  return std::to_string(std::chrono::ceil<std::chrono::minutes>(time).count()) + " minutes";
}

}  // namespace ddssec::cyclonedds
