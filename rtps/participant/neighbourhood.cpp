#include "rtps/participant/neighbourhood.hpp"

#include <algorithm>
#include <map>
#include <string>

#include "rtps/participant/participant.hpp"

namespace ddssec::rtps {

std::shared_ptr<Neighbourhood> Neighbourhood::of(DomainId domain, std::string_view tag) {
  static std::mutex mutex;
  static std::map<std::pair<DomainId, std::string>, std::weak_ptr<Neighbourhood>> all;
  const std::lock_guard lock(mutex);
  std::erase_if(all, [](const auto& entry) { return entry.second.expired(); });
  auto& known = all[{domain, std::string(tag)}];
  auto out = known.lock();
  if (!out) known = out = std::make_shared<Neighbourhood>();
  return out;
}

Participant* Neighbourhood::find(const GuidPrefix& prefix) const {
  const auto at =
      std::ranges::find_if(members_, [&](const auto* p) { return p->prefix() == prefix; });
  return at == members_.end() ? nullptr : *at;
}

}  // namespace ddssec::rtps
