#include "plugins/cryptography/awaited_tokens.hpp"

namespace ddssec::cryptography {

void AwaitedTokens::await(std::uint64_t exchange, const TokenKey& key, Time now) {
  if (awaited_.size() >= kMax || awaited_.contains({exchange, key})) return;
  auto& of_subject = of_subject_[named_subject(key.remote.prefix)];
  if (of_subject >= kMaxOfSubject) return;
  awaited_.try_emplace({exchange, key}, Wait{now});
  ++of_subject;
}

void AwaitedTokens::came(std::uint64_t exchange, const TokenKey& key) {
  if (const auto entry = awaited_.find({exchange, key}); entry != awaited_.end()) erase(entry);
}

void AwaitedTokens::end(std::uint64_t exchange) {
  for (auto at = first_of(exchange); at != awaited_.end() && at->first.first == exchange;)
    erase(at++);
}

void AwaitedTokens::erase(All::iterator entry) {
  const auto of_subject = of_subject_.find(named_subject(entry->first.second.remote.prefix));
  if (--of_subject->second == 0) of_subject_.erase(of_subject);
  awaited_.erase(entry);
}

bool AwaitedTokens::contains(std::uint64_t exchange, const TokenKey& key) const {
  return awaited_.contains({exchange, key});
}

}  // namespace ddssec::cryptography
