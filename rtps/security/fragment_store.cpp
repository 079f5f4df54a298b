#include "rtps/security/fragment_store.hpp"

#include <algorithm>

namespace ddssec::rtps {

std::deque<FragmentStore::Partial>::iterator FragmentStore::place_for(const GuidPrefix& sender,
                                                                      const DataFrag& frag) {
  const auto same = std::ranges::find_if(partial_, [&](const auto& p) {
    return p.sender == sender && p.number == frag.sequence_number;
  });
  if (same != partial_.end()) return same;
  const auto of_sender = std::ranges::count(partial_, sender, &Partial::sender);
  if (static_cast<std::size_t>(of_sender) >= kMostPerSender)
    partial_.erase(std::ranges::find(partial_, sender, &Partial::sender));
  if (partial_.size() >= kMost) partial_.pop_front();
  const auto total = frag.total();
  partial_.push_back({sender, frag.sequence_number, frag.fragment_size, Bytes(frag.sample_size),
                      std::vector<bool>(total), total});
  return std::prev(partial_.end());
}

std::optional<Bytes> FragmentStore::add(const GuidPrefix& sender, const DataFrag& frag) {
  if (frag.sample_size > kLargestMessage) return std::nullopt;
  const auto partial = place_for(sender, frag);
  if (partial->fragment_size != frag.fragment_size || partial->octets.size() != frag.sample_size)
    return std::nullopt;
  const auto begin = std::size_t{frag.first.value - 1} * frag.fragment_size;
  std::ranges::copy(frag.payload, partial->octets.begin() + static_cast<std::ptrdiff_t>(begin));
  for (std::uint32_t i = 0; i < frag.count; ++i) {
    auto have = partial->have[frag.first.value - 1 + i];
    partial->missing -= have ? 0 : 1;
    have = true;
  }
  if (partial->missing > 0) return std::nullopt;
  auto whole = std::move(partial->octets);
  partial_.erase(partial);
  return whole;
}

void FragmentStore::forget(const GuidPrefix& sender) {
  std::erase_if(partial_, [&](const auto& p) { return p.sender == sender; });
}

}  // namespace ddssec::rtps
