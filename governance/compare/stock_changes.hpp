// What a change of a document changes for stock products, and not for ddssec.
#pragma once

#include <vector>

#include "governance/as_read.hpp"
#include "governance/compare/governance_diff.hpp"
#include "governance/compare/permissions_diff.hpp"

namespace ddssec::governance {

/// Adds to the readings of `ours`, the comparison of two documents, what the comparison of the same
/// documents as Cyclone DDS and Fast DDS read them has more.
void add_stock_changes(const GovernanceDiff& stock, GovernanceDiff& ours);

/// The same for one product.
struct StockPermissionsDiff {
  StockProduct product;
  PermissionsDiff diff;
};
void add_stock_changes(const std::vector<StockPermissionsDiff>& stock, PermissionsDiff& ours);

}  // namespace ddssec::governance
