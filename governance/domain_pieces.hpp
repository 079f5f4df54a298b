// The line of domain ids, cut where documents begin and end to speak of them.
#pragma once

#include <bitset>
#include <span>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// Cuts 0 to kHighestDomainId so that no given range begins or ends within a piece.
class DomainCuts {
 public:
  void add(const DomainSet& domains);
  /// Ascending; together the whole line.
  std::vector<DomainRange> pieces() const;

 private:
  void cut(DomainId at);
  std::bitset<kHighestDomainId + 1> begins_;
};

/// Sorts, and joins what touches or overlaps.
std::vector<DomainRange> joined(std::vector<DomainRange> ranges);

}  // namespace ddssec::governance
