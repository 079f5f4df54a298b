// Finds the effects of a change on stock products that it does not have on ddssec.
#pragma once

#include <vector>

#include "governance/compare/governance_diff.hpp"
#include "governance/compare/permissions_diff.hpp"
#include "governance/product_reading.hpp"

namespace ddssec::governance {

/// The comparison of the same two documents as one product reads them.
struct StockGovernanceDiff {
  StockProduct product;
  GovernanceDiff diff;
};
/// Adds to the interpretations of `ours`, the comparison of two documents, those changes that
/// appear only in the comparisons for the products.
void add_stock_changes(const std::vector<StockGovernanceDiff>& stock, GovernanceDiff& ours);

/// Like StockGovernanceDiff, for permissions.
struct StockPermissionsDiff {
  StockProduct product;
  PermissionsDiff diff;
  /// True if the product applies the documents in this way to its own endpoints only.
  bool is_of_own_endpoints = false;
};
void add_stock_changes(const std::vector<StockPermissionsDiff>& stock, PermissionsDiff& ours);

}  // namespace ddssec::governance
