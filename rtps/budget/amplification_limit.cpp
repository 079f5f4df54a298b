#include "rtps/budget/amplification_limit.hpp"

#include <algorithm>
#include <limits>
#include <utility>

namespace ddssec::rtps {
namespace {

constexpr auto kUnlimited = std::numeric_limits<std::size_t>::max();

Locator without_port(const Locator& address) { return {address.kind, 0, address.address}; }

}  // namespace

AmplificationLimit::Source* AmplificationLimit::Account::find(const SourceAddress& address) {
  const auto at = std::ranges::find(sources, address, &Source::address);
  return at == sources.end() ? nullptr : &*at;
}

void AmplificationLimit::Account::add(const SourceAddress& address) {
  if (find(address) == nullptr) sources.push_back({address});
}

bool AmplificationLimit::Account::has_use_for(const SourceAddress& address) const {
  return std::ranges::any_of(addresses, [&](const auto& one) {
    return one.second == address || SourceAddress(one.first) == address;
  });
}

// An attacker may have been the first to announce the address of an honest peer, so the address
// itself can also pay.
AmplificationLimit::Source* AmplificationLimit::Account::payer(const Locator& to) {
  const auto at = std::ranges::find(addresses, to, [](const auto& one) { return one.first; });
  if (at == addresses.end()) return nullptr;
  auto *own = find(SourceAddress(to)), *announcer = find(at->second);
  return own->saved >= announcer->saved ? own : announcer;
}

bool AmplificationLimit::Account::is_proven(const Locator& to) {
  const auto* source = find(SourceAddress(to));
  return source != nullptr && source->is_proven;
}

std::size_t AmplificationLimit::Account::left(const Locator& to) {
  if (is_proven(to)) return kUnlimited;
  const auto* source = payer(to);
  return source == nullptr || source->saved == 0 ? 0 : source->saved - 1;
}

AmplificationLimit::Account* AmplificationLimit::find(const GuidPrefix& participant) {
  if (accounts_.empty()) return nullptr;
  const auto at = accounts_.find(participant);
  return at == accounts_.end() ? nullptr : &at->second;
}

void AmplificationLimit::begin_datagram(const SourceAddress& source, std::size_t octets) {
  source_ = source;
  not_credited_ = octets;
}

void AmplificationLimit::begin(const GuidPrefix& participant, std::span<const Locator> addresses,
                               std::span<const SourceAddress> sources) {
  accounts_[participant] = {};
  set_addresses(participant, addresses, sources);
}

void AmplificationLimit::set_addresses(const GuidPrefix& participant,
                                       std::span<const Locator> addresses,
                                       std::span<const SourceAddress> sources) {
  auto* account = find(participant);
  if (account == nullptr) return;
  // If memory runs out, nothing has changed: each address still has a source.
  Account changed{.sources = account->sources, .proven = account->proven, .turn = account->turn};
  for (std::size_t i = 0; i < std::min(addresses.size(), sources.size()); ++i) {
    changed.addresses.emplace_back(addresses[i], sources[i]);
    changed.add(sources[i]);
    changed.add(SourceAddress(addresses[i]));
  }
  std::erase_if(changed.sources,
                [&](const auto& source) { return !changed.has_use_for(source.address); });
  std::erase_if(changed.proven, [&](const auto& host) {
    return std::ranges::none_of(changed.addresses,
                                [&](const auto& one) { return without_port(one.first) == host; });
  });
  *account = std::move(changed);
}

// If a peer sends from none of its announced addresses, it is not known which of them is its own.
// So the addresses are credited in turn.
std::size_t AmplificationLimit::add_credit(const GuidPrefix& participant) {
  auto* account = not_credited_ == 0 ? nullptr : find(participant);
  if (account == nullptr || account->addresses.empty()) return 0;
  auto* known = account->find(source_);
  const auto turn = known != nullptr ? 0 : account->turn++ % account->addresses.size();
  auto& source = known != nullptr ? *known : *account->find(account->addresses[turn].second);
  const auto before = source.saved;
  source.saved = std::min(kMaxSaved, before + kFactor * std::exchange(not_credited_, 0));
  return source.saved - before;
}

Bytes AmplificationLimit::challenge(const GuidPrefix& participant, const Locator& host) const {
  constexpr std::size_t kSize = 16;
  if (!secret_) return {};
  const auto digest = hmac_sha256(*secret_, {participant.octets, host.address});
  return {digest.begin(), digest.begin() + kSize};
}

bool AmplificationLimit::prove(const GuidPrefix& participant, BytesView repeated) {
  auto* account = repeated.empty() ? nullptr : find(participant);
  if (account == nullptr) return false;
  const auto at = std::ranges::find_if(account->addresses, [&](const auto& one) {
    return constant_time_equal(repeated, challenge(participant, one.first));
  });
  if (at == account->addresses.end()) return false;
  const auto host = without_port(at->first);
  if (std::ranges::find(account->proven, host) == account->proven.end())
    account->proven.push_back(host);
  account->find(SourceAddress(host))->is_proven = true;
  return true;
}

bool AmplificationLimit::is_proven(const GuidPrefix& participant, const Locator& address) {
  auto* account = find(participant);
  return account != nullptr &&
         std::ranges::find(account->proven, without_port(address)) != account->proven.end();
}

std::size_t AmplificationLimit::left(const GuidPrefix& participant, std::span<const Locator> to) {
  auto* account = find(participant);
  if (account == nullptr) return kUnlimited;
  std::size_t out = 0;
  for (const auto& locator : to) out = std::max(out, account->left(locator));
  return out;
}

LocatorList AmplificationLimit::charge(const GuidPrefix& participant, std::size_t octets,
                                       std::span<const Locator> to) {
  auto* account = find(participant);
  if (account == nullptr) return {to.begin(), to.end()};
  LocatorList out;
  for (const auto& locator : to) {
    if (octets > account->left(locator)) continue;
    if (!account->is_proven(locator)) account->payer(locator)->saved -= octets;
    out.push_back(locator);
  }
  return out;
}

}  // namespace ddssec::rtps
