#include "rtps/security/early_tokens.hpp"

#include <algorithm>

namespace ddssec::rtps {

bool EarlyTokens::keep(GenericMessage message, std::size_t octets, MonotonicTime now) {
  const Guid local = message.destination_endpoint, remote = message.source_endpoint;
  const auto of_pair = [&](const Kept& kept) { return kept.is_of(local, remote); };
  if (std::ranges::count_if(kept_, of_pair) >= std::ptrdiff_t{kMaxOfPair})
    drop(std::ranges::find_if(kept_, of_pair));
  while (!kept_.empty() && !has_room(octets) && now - kept_.front().since >= kMinKept)
    drop(kept_.begin());
  if (!has_room(octets)) return false;
  octets_ += octets;
  kept_.push_back({std::move(message), octets, now});
  return true;
}

bool EarlyTokens::take(const Guid& local, const Guid& remote,
                       const std::function<void(const GenericMessage&)>& use) {
  const auto taken = std::erase_if(kept_, [&](const Kept& kept) {
    if (!kept.is_of(local, remote)) return false;
    use(kept.message);
    octets_ -= kept.octets;
    return true;
  });
  return taken > 0;
}

void EarlyTokens::drop(std::vector<Kept>::iterator at) {
  octets_ -= at->octets;
  kept_.erase(at);
}

}  // namespace ddssec::rtps
