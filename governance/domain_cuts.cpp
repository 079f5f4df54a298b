#include "governance/domain_cuts.hpp"

#include <algorithm>

namespace ddssec::governance {

void DomainCuts::cut(DomainId at) {
  if (at > 0 && at <= kMaxGovernedDomainId) begins_.set(static_cast<std::size_t>(at));
}

void DomainCuts::add(const DomainSet& domains) {
  for (const auto& range : domains.ranges) {
    cut(range.first);
    if (range.last < kMaxGovernedDomainId) cut(range.last + 1);
  }
}

std::vector<DomainRange> DomainCuts::pieces() const {
  std::vector<DomainRange> pieces = {{0, kMaxGovernedDomainId}};
  for (DomainId id = 1; id <= kMaxGovernedDomainId; ++id) {
    if (!begins_.test(static_cast<std::size_t>(id))) continue;
    pieces.back().last = id - 1;
    pieces.push_back({id, kMaxGovernedDomainId});
  }
  return pieces;
}

std::vector<DomainRange> joined(std::vector<DomainRange> ranges) {
  std::ranges::sort(ranges, {}, &DomainRange::first);
  std::vector<DomainRange> result;
  for (const auto& range : ranges) {
    if (result.empty() || range.first > result.back().last + 1) {
      result.push_back(range);
    } else {
      result.back().last = std::max(result.back().last, range.last);
    }
  }
  return result;
}

}  // namespace ddssec::governance
