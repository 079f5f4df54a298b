#include "rtps/durability/store_shares.hpp"

#include <bit>

namespace ddssec::rtps {

StoreShares::Account StoreShares::account(const GuidPrefix& identity) {
  if (const auto known = accounts_.find(identity); known != accounts_.end()) return known->second;
  shares_.reserve(shares_.size() + 1);
  const auto next = static_cast<Account>(shares_.size());
  accounts_.emplace(identity, next);
  shares_.push_back({identity});
  return next;
}

void StoreShares::refuse(const GuidPrefix& identity) {
  auto& share = shares_[account(identity)];
  if (std::has_single_bit(share.refused + 1)) unreported_.push_back({identity, share.refused + 1});
  ++share.refused;
}

}  // namespace ddssec::rtps
