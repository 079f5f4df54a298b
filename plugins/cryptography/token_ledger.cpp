#include "plugins/cryptography/token_ledger.hpp"

#include <algorithm>

#include "base/rollback.hpp"
#include "plugins/cryptography/key_material.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::string_view kDocument = "a key token message";

bool has_place_for_ticket(std::span<const spi::Token> tokens) {
  return !tokens.empty() && !tokens.front().binary_properties.empty() &&
         tokens.front().binary_properties.front().value.size() >= sizeof(Ticket::octets);
}

}  // namespace

void wipe_tokens(std::span<spi::Token> tokens) {
  for (auto& token : tokens)
    for (auto& one : token.binary_properties) wipe(one.value);
}

PackedTokens::PackedTokens(std::span<const spi::Token> tokens) {
  const auto material_of = [](const spi::Token& token) -> const Bytes& {
    return token.binary_properties.front().value;
  };
  std::size_t size = 0;
  for (const auto& token : tokens) size += 1 + material_of(token).size();
  octets_.reserve(size);
  for (const auto& token : tokens) {
    const auto& material = material_of(token);
    octets_.push_back(static_cast<std::uint8_t>(material.size()));
    octets_.insert(octets_.end(), material.begin(), material.end());
  }
}

PackedTokens& PackedTokens::operator=(PackedTokens&& other) noexcept {
  octets_.swap(other.octets_);
  return *this;
}

std::vector<spi::Token> PackedTokens::tokens() const {
  std::vector<spi::Token> out;
  for (auto rest = BytesView(octets_); !rest.empty();) {
    const auto size = rest.front();
    out.push_back(token_of_material(rest.subspan(1, size)));
    rest = rest.subspan(1 + std::size_t{size});
  }
  return out;
}

// The first six octets of a proven prefix are bound to the subject (DDS-Security 1.2,
// clause 10.3.3).
std::uint64_t TokenLedger::account_of(const Key& key, const TokenSender& sender) {
  return sender.is_proven ? named_subject(key.remote.prefix) : kUnproven | sender.exchange;
}

// No transformation kind begins with this first octet, so a ticket is never parsed as key
// material.
Ticket TokenLedger::fresh_ticket() {
  Ticket ticket{{0xff, 't', 'i', 'c', 'k', 'e', 't', 0}};
  for (std::size_t i = 0; i < 8; ++i)
    ticket.octets[15 - i] = static_cast<std::uint8_t>(next_ticket_ >> (8 * i));
  ++next_ticket_;
  return ticket;
}

// While the host has a ticket, only the message that brought the ticket passes, as a
// retransmission. The host may have had no space for it the first time.
TokenDecision TokenLedger::of_held(Entry& entry, const TokenMessage& message, const Age& age) {
  if (age == entry.passed) return {TokenDecision::Kind::ticket, entry.ticket};
  if (age > entry.newest) {
    entry.tokens = PackedTokens(message.tokens);
    entry.newest = age;
  }
  const bool is_same_exchange = age.exchange == entry.passed.exchange;
  return {is_same_exchange ? TokenDecision::Kind::repeated : TokenDecision::Kind::hidden};
}

// True if the host can no longer hold the ticket of a former exchange. A ticket for builtin
// endpoints is presented when the host matches them.
bool TokenLedger::is_given_up(const Key& key, Entry& entry, bool are_builtin_matched,
                              std::chrono::nanoseconds now) {
  if (key.remote.entity == kEntityIdParticipant) return true;
  if (!are_builtin_matched) entry.matched_since.reset();
  if (are_builtin_matched && !entry.matched_since) entry.matched_since = now;
  return entry.matched_since && now - *entry.matched_since >= kComing;
}

Status TokenLedger::check_room(const Key& key, const TokenSender& sender) {
  const auto found = accounts_.find(account_of(key, sender));
  const auto [pending, all] = found == accounts_.end() ? Account{} : found->second;
  const bool waits = key.remote.entity != kEntityIdParticipant &&
                     !rtps::is_builtin(key.remote.entity) &&
                     !awaited_.contains(sender.exchange, key);
  const auto of_certificate = waits ? kMaxPending : kMaxPending + kReserved;
  const auto most =
      sender.is_proven ? of_certificate : std::min(kMaxPending, kMaxUnproven - unproven_pending_);
  if (pending >= most)
    return fail(Code::crypto_tokens_crowded, {.document = std::string(kDocument),
                                              .expected = std::to_string(most),
                                              .note = "of " + key.remote.to_string()});
  if (all >= 2 * kMaxPending) forget_used(key, sender);
  return {};
}

void TokenLedger::add(const Key& key, Entry fresh) {
  auto& account = accounts_[fresh.account];
  const auto entry = entries_.emplace(key, std::move(fresh)).first;
  Rollback forget([&] { entries_.erase(entry); });
  const auto held = tickets_.emplace(entry->second.ticket, entry).first;
  Rollback forget_ticket([&] { tickets_.erase(held); });
  by_exchange_.emplace(entry->second.passed.exchange, &entry->first);
  forget_ticket.release();
  forget.release();
  ++account.pending, ++account.all;
  if ((entry->second.account & kUnproven) != 0) ++unproven_pending_;
}

Result<TokenDecision> TokenLedger::note(const TokenMessage& message, const TokenSender& sender,
                                        bool are_builtin_matched, std::chrono::nanoseconds now) {
  const std::lock_guard lock(mutex_);
  forget_old(now);
  const auto exchange = sender.exchange;
  const Key key{message.remote, message.local};
  const Age age{exchange, message.number};
  if (has_taken(age)) return TokenDecision{TokenDecision::Kind::hidden};
  std::optional<TicketUser> user;
  if (const auto known = entries_.find(key); known != entries_.end()) {
    auto& entry = known->second;
    if (entry.is_pending) {
      const bool is_other = exchange > entry.passed.exchange && rtps::is_builtin(key.remote.entity);
      if (!is_other) return of_held(entry, message, age);
      if (!is_given_up(key, entry, are_builtin_matched, now))
        return TokenDecision{TokenDecision::Kind::later};
    } else if (exchange == entry.newest.exchange && age <= entry.newest) {
      return TokenDecision{TokenDecision::Kind::hidden};  // the host already had it, or ignored it
    } else if (entry.awaited_by && entry.awaited_by->exchange == exchange) {
      user = entry.awaited_by;
    }
    erase(known);
  }
  DDSSEC_RETURN_IF_ERROR(check_room(key, sender));
  const auto ticket = fresh_ticket();
  add(key, {.passed = age,
            .newest = age,
            .account = account_of(key, sender),
            .passed_at = now,
            .ticket = ticket,
            .tokens = PackedTokens(message.tokens)});
  if (user) return TokenDecision{TokenDecision::Kind::awaited, ticket, *user};
  return TokenDecision{TokenDecision::Kind::ticket, ticket};
}

std::optional<TokenLedger::StoredTokens> TokenLedger::redeem(std::span<const spi::Token> tokens,
                                                             const TicketUser& user) {
  if (!has_place_for_ticket(tokens)) return std::nullopt;
  Ticket ticket;
  std::ranges::copy_n(tokens.front().binary_properties.front().value.begin(),
                      std::ssize(ticket.octets), ticket.octets.begin());
  const std::lock_guard lock(mutex_);
  const auto found = tickets_.find(ticket);
  if (found == tickets_.end()) return std::nullopt;
  auto& [key, entry] = *found->second;
  awaited_.came(user.exchange, key);
  remove_pending(entry);
  const auto packed = std::exchange(entry.tokens, {});
  if (user.exchange <= entry.newest.exchange) return StoredTokens{key.remote, packed.tokens()};
  entry.awaited_by = user;
  return StoredTokens{key.remote, {}};
}

void TokenLedger::remove_pending(Entry& entry) {
  tickets_.erase(entry.ticket);
  entry.is_pending = false;
  --accounts_.at(entry.account).pending;
  if ((entry.account & kUnproven) != 0) --unproven_pending_;
}

TokenLedger::Entries::iterator TokenLedger::first_of(std::uint64_t exchange) {
  const auto first = by_exchange_.lower_bound({exchange, nullptr});
  const bool is_there = first != by_exchange_.end() && first->first == exchange;
  return is_there ? entries_.find(*first->second) : entries_.end();
}

void TokenLedger::end(std::uint64_t exchange, std::chrono::nanoseconds now) {
  const std::lock_guard lock(mutex_);
  forget_old(now);
  stranded_.erase(exchange);
  awaited_.end(exchange);
  if (taken_.contains(exchange) || first_of(exchange) != entries_.end())
    ended_.push_back({now, exchange});
}

bool TokenLedger::poll_stranded(std::uint64_t exchange, std::chrono::nanoseconds now) {
  const std::lock_guard lock(mutex_);
  forget_old(now);
  bool are_stranded = stranded_.erase(exchange) > 0;
  awaited_.review(exchange, now, [&](const Key& key, std::chrono::nanoseconds since) {
    const auto fate = fate_of(exchange, key, since);
    are_stranded |= fate == Fate::lost;
    return fate != Fate::not_here;
  });
  if (are_stranded) forget_awaited(exchange, now);
  return are_stranded;
}

void TokenLedger::await(std::uint64_t exchange, const Key& key, std::chrono::nanoseconds now) {
  const std::lock_guard lock(mutex_);
  const auto known = entries_.find(key);
  const bool has_come = known != entries_.end() && !known->second.is_pending &&
                        !known->second.is_lost && known->second.newest.exchange == exchange;
  if (!has_come) awaited_.await(exchange, key, now);
}

// Tokens of the same exchange that the host did not use in kHostKeeps pass at once in the next
// exchange, so they cannot be counted as lost twice.
TokenLedger::Fate TokenLedger::fate_of(std::uint64_t exchange, const Key& key,
                                       std::chrono::nanoseconds since) {
  const auto known = entries_.find(key);
  if (known == entries_.end()) return Fate::not_here;
  const auto& entry = known->second;
  if (entry.newest.exchange > exchange) return Fate::not_here;
  if (!entry.is_pending && !entry.is_lost) return Fate::not_here;
  if (entry.passed.exchange < exchange) {
    if (entry.is_lost) return Fate::not_here;
    return entry.newest.exchange == exchange ? Fate::lost : Fate::undecided;
  }
  const bool was_dropped = since - entry.passed_at >= kHostKeeps;
  if (entry.is_lost) return was_dropped ? Fate::lost : Fate::not_here;
  return was_dropped && has_taken(entry.passed) ? Fate::lost : Fate::undecided;
}

void TokenLedger::forget_awaited(std::uint64_t exchange, std::chrono::nanoseconds now) {
  awaited_.each(exchange, [&](const Key& key, std::chrono::nanoseconds since) {
    const auto known = entries_.find(key);
    if (known == entries_.end() || now - since < std::chrono::seconds(1)) return;
    const auto& entry = known->second;
    if (entry.is_lost ||
        (entry.is_pending && (entry.passed.exchange < exchange || has_taken(entry.passed))))
      erase(known);
  });
  awaited_.end(exchange);
}

void TokenLedger::acknowledged(std::uint64_t exchange, std::uint64_t next,
                               std::chrono::nanoseconds now) {
  const std::lock_guard lock(mutex_);
  forget_old(now);
  if (!taken_.contains(exchange) && first_of(exchange) == entries_.end()) return;
  auto& taken = taken_[exchange];
  if (next <= taken.next) return;
  if (taken.latest == nullptr || now - taken.latest->since >= kSpan) {
    acknowledged_.push_back({now, exchange, next});
    // A deque does not move elements when others are added or removed at its ends.
    taken.latest = &acknowledged_.back();
  }
  taken.next = taken.latest->next = next;
}

bool TokenLedger::has_taken(const Age& age) const {
  const auto taken = taken_.find(age.exchange);
  return taken != taken_.end() && age.number < taken->second.next;
}

void TokenLedger::forget_unused(std::uint64_t exchange, std::uint64_t next) {
  for (auto at = by_exchange_.lower_bound({exchange, nullptr});
       at != by_exchange_.end() && at->first == exchange;) {
    const auto entry = entries_.find(*(at++)->second);
    const auto& known = entry->second;
    if (!known.is_pending || known.passed.number >= next) continue;
    const bool has_account = (known.account & kUnproven) == 0;
    if (has_account && known.newest.exchange == exchange)
      note_lost(entry);
    else
      give_up(entry);
  }
}

void TokenLedger::forget_old(std::chrono::nanoseconds now) {
  while (!acknowledged_.empty() && now - acknowledged_.front().since >= kSpan + kMemory) {
    const auto& oldest = acknowledged_.front();
    forget_unused(oldest.exchange, oldest.next);
    const auto taken = taken_.find(oldest.exchange);
    if (taken != taken_.end() && taken->second.latest == &oldest) taken->second.latest = nullptr;
    acknowledged_.pop_front();
  }
  while (!ended_.empty() && now - ended_.front().at >= kMemory) {
    const auto exchange = ended_.front().exchange;
    ended_.pop_front();
    for (auto entry = first_of(exchange); entry != entries_.end(); entry = first_of(exchange))
      give_up(entry);
    taken_.erase(exchange);
  }
}

// Entries that were used are stored only to detect repetitions.
void TokenLedger::forget_used(const Key& key, const TokenSender& sender) {
  const auto account = account_of(key, sender);
  const auto forget = [&](Entries::iterator entry) {
    if (entry->second.account == account && !entry->second.is_pending) erase(entry);
  };
  if (!sender.is_proven) {
    for (auto at = by_exchange_.lower_bound({sender.exchange, nullptr});
         at != by_exchange_.end() && at->first == sender.exchange;)
      forget(entries_.find(*(at++)->second));
    return;
  }
  Key first{};
  std::copy_n(key.remote.prefix.octets.begin(), kSubjectSize, first.remote.prefix.octets.begin());
  for (auto at = entries_.lower_bound(first);
       at != entries_.end() && account_of(at->first, sender) == account;)
    forget(at++);
}

void TokenLedger::note_lost(Entries::iterator entry) {
  remove_pending(entry->second);
  entry->second.tokens = {};
  entry->second.is_lost = true;
}

void TokenLedger::give_up(Entries::iterator entry) {
  const auto& known = entry->second;
  if (known.is_pending && known.newest.exchange != known.passed.exchange)
    stranded_.insert(known.newest.exchange);
  erase(entry);
}

void TokenLedger::erase(Entries::iterator entry) {
  if (entry->second.is_pending) remove_pending(entry->second);
  const auto account = accounts_.find(entry->second.account);
  if (--account->second.all == 0) accounts_.erase(account);
  by_exchange_.erase({entry->second.passed.exchange, &entry->first});
  entries_.erase(entry);
}

std::size_t TokenLedger::size() const {
  const std::lock_guard lock(mutex_);
  return entries_.size();
}

std::size_t TokenLedger::pending() const {
  const std::lock_guard lock(mutex_);
  return tickets_.size();
}

}  // namespace ddssec::cryptography
