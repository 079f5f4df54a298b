#include "cli/agent/silent_responders.hpp"

namespace ddssec::cli {

void SilentResponders::note(uid_t owner, std::string url, Moment now) {
  if (url.empty()) return;
  const auto has_ended = [&](const auto& one) { return one.second <= now; };
  for (auto& [user, urls] : silent_) std::erase_if(urls, has_ended);
  std::erase_if(silent_, [](const auto& one) { return one.second.empty(); });
  if (silent_.size() >= kMaxOwners && !silent_.contains(owner)) return;
  auto& urls = silent_[owner];
  if (urls.size() < kMaxUrls || urls.contains(url)) urls[std::move(url)] = now + kLeftAlone;
}

std::vector<std::string> SilentResponders::silent_for(uid_t owner, Moment now) const {
  std::vector<std::string> out;
  const auto found = silent_.find(owner);
  if (found == silent_.end()) return out;
  for (const auto& [url, end] : found->second)
    if (now < end) out.push_back(url);
  return out;
}

}  // namespace ddssec::cli
