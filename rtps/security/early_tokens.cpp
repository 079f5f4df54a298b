#include "rtps/security/early_tokens.hpp"

#include <algorithm>
#include <iterator>

namespace ddssec::rtps {

bool EarlyTokens::keep(GenericMessage message, std::size_t octets, MonotonicTime now) {
  const Guid local = message.destination_endpoint, remote = message.source_endpoint;
  const auto of_pair = [&](const KeptMessage& kept) { return kept.is_of(local, remote); };
  if (std::ranges::count_if(kept_, of_pair) >= std::ptrdiff_t{kMaxOfPair})
    drop(std::ranges::find_if(kept_, of_pair));
  while (!kept_.empty() && !has_room(octets) && now - kept_.front().since >= kMinKept)
    drop(kept_.begin());
  if (!has_room(octets)) return false;
  octets_ += octets;
  kept_.push_back({std::move(message), octets, now});
  return true;
}

std::vector<EarlyTokens::KeptMessage> EarlyTokens::remove_all_of(const Guid& local,
                                                                 const Guid& remote) {
  const auto others = std::ranges::stable_partition(
      kept_, [&](const KeptMessage& kept) { return !kept.is_of(local, remote); });
  std::vector<KeptMessage> out(std::make_move_iterator(others.begin()),
                               std::make_move_iterator(others.end()));
  kept_.erase(others.begin(), others.end());
  for (const auto& one : out) octets_ -= one.octets;
  return out;
}

bool EarlyTokens::consume(const Guid& local, const Guid& remote,
                          const std::function<bool(const GenericMessage&)>& use) {
  bool any = false;
  for (auto& one : remove_all_of(local, remote)) {
    if (use(one.message)) {
      any = true;
      continue;
    }
    octets_ += one.octets;
    kept_.insert(std::ranges::upper_bound(kept_, one.since, {}, &KeptMessage::since),
                 std::move(one));
  }
  return any;
}

void EarlyTokens::drop(std::vector<KeptMessage>::iterator at) {
  octets_ -= at->octets;
  kept_.erase(at);
}

}  // namespace ddssec::rtps
