#include "plugins/cryptography/awaited_tokens.hpp"

namespace ddssec::cryptography {

void AwaitedTokens::await(std::uint64_t exchange, const TokenKey& key, Time now) {
  if (awaited_.size() < kMax) awaited_.try_emplace({exchange, key}, Waiting{now});
}

void AwaitedTokens::came(std::uint64_t exchange, const TokenKey& key) {
  awaited_.erase({exchange, key});
}

void AwaitedTokens::end(std::uint64_t exchange) {
  auto last = first_of(exchange);
  while (last != awaited_.end() && last->first.first == exchange) ++last;
  awaited_.erase(first_of(exchange), last);
}

bool AwaitedTokens::contains(std::uint64_t exchange, const TokenKey& key) const {
  return awaited_.contains({exchange, key});
}

}  // namespace ddssec::cryptography
