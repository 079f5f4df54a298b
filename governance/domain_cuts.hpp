// The range of all domain ids, cut where domain ranges of documents begin and end.
#pragma once

#include <bitset>
#include <vector>

#include "governance/model.hpp"

namespace ddssec::governance {

/// Cuts 0 to kMaxGovernedDomainId so that no given range begins or ends inside a piece.
class DomainCuts {
 public:
  void add(const DomainSet& domains);
  /// Returns the pieces in ascending order; together they are all domain ids.
  std::vector<DomainRange> pieces() const;

 private:
  void cut(DomainId at);
  std::bitset<kMaxGovernedDomainId + 1> begins_;
};

/// Sorts the ranges, and joins those that touch or overlap.
std::vector<DomainRange> joined(std::vector<DomainRange> ranges);

}  // namespace ddssec::governance
