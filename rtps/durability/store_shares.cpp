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

void StoreShares::refuse(Account account, const Refused& change) {
  ++refused_;
  auto& share = shares_[account];
  if (std::has_single_bit(++share.refused)) news_.push_back({share.identity, share.refused});
  auto& crowd = crowds_.try_emplace(account, Crowd{change, {}}).first->second;
  crowd.instances.emplace(change.stream, change.instance);
}

bool StoreShares::is_behind(Account account, std::int64_t stream, const KeyHash& instance) const {
  const auto at = crowds_.find(account);
  return at != crowds_.end() && at->second.instances.contains({stream, instance});
}

std::set<GuidPrefix> StoreShares::crowded() const {
  std::set<GuidPrefix> out;
  for (const auto& [account, crowd] : crowds_) out.insert(shares_[account].identity);
  return out;
}

}  // namespace ddssec::rtps
