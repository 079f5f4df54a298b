#include "rtps/durability/store_shares.hpp"

#include <bit>

namespace ddssec::rtps {

StoreShares::Account StoreShares::account(const GuidPrefix& identity) {
  const auto next = static_cast<Account>(shares_.size());
  const auto [at, is_new] = accounts_.try_emplace(identity, next);
  if (is_new) shares_.push_back({identity});
  return at->second;
}

void StoreShares::clear() {
  for (auto& share : shares_) share.octets = 0;
}

void StoreShares::refuse(Account account) {
  auto& share = shares_[account];
  if (std::has_single_bit(++share.refused)) news_.push_back({share.identity, share.refused});
}

}  // namespace ddssec::rtps
