// Keeps key tokens from the arrival of their message until the host uses them.
//
// Cyclone DDS stores tokens until their endpoints are matched: any number of them, for five minutes
// each. If tokens for the same two endpoints come again in that time, it corrupts its memory. So it
// receives tickets instead of tokens.
#pragma once

#include <chrono>
#include <cstdint>
#include <deque>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "base/hash.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/awaited_tokens.hpp"
#include "plugins/cryptography/token_message.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

/// A match for which the host presents a ticket, possibly one of a session that has ended.
struct TicketUser {
  std::uint64_t exchange = 0;  ///< the present exchange with the peer; 0 if there is none
  std::int64_t local = 0;      ///< crypto handles of the local endpoint and the peer's
  std::int64_t remote = 0;
  bool operator==(const TicketUser&) const = default;
};

/// The sender of a message.
struct TokenSender {
  std::uint64_t exchange;  ///< number of the authentication; later ones are greater
  bool is_proven = true;   ///< authentication provided the prefix that the message names
};

/// The decision about a message.
struct TokenDecision {
  enum class Kind : std::uint8_t {
    ticket,    ///< passed to the host with the ticket in it
    hidden,    ///< passed to the host under a class that it does not know
    repeated,  ///< hidden, because the host holds a ticket of the same exchange
    later,     ///< not accepted now; the sender will send it again
    awaited,   ///< hidden; the ticket is for `user`, for which the host believes it has keys
  };
  Kind kind;
  Ticket ticket = {};
  TicketUser user = {};
  bool operator==(const TokenDecision&) const = default;
};

/// The key material of usable tokens, packed into one block without the parts that are the same in
/// all tokens. Wiped at destruction.
class PackedTokens {
 public:
  PackedTokens() = default;
  explicit PackedTokens(std::span<const spi::Token> tokens);
  PackedTokens(PackedTokens&&) noexcept = default;
  PackedTokens& operator=(PackedTokens&& other) noexcept;
  ~PackedTokens() { wipe(octets_); }

  std::vector<spi::Token> tokens() const;

 private:
  Bytes octets_;  ///< for each token its length (one octet), then that many octets
};

/// The ledger: keeps the tokens for two endpoints and gives the host a ticket for them.
/// Thread-safe.
///
/// The host holds at most one ticket for two endpoints. Tokens that come meanwhile replace the
/// stored ones, and the host does not see them. The host names no GUIDs when it presents a ticket;
/// the ticket identifies the two endpoints.
///
/// A message that was decrypted may still not have reached the host. So when its sender
/// authenticates again, the host may or may not hold the former ticket:
/// - Tickets of a participant are dropped with the participant.
/// - Tickets of builtin endpoints are used as soon as the host matches these endpoints. New tokens
///   are refused until then.
/// - For other endpoints nothing is known for six minutes. If the host does not present the ticket
///   in that time, it never had it, and tokens that came since then must come again in a further
///   session. This is known sooner if the host has matched the two endpoints meanwhile: it would
///   have presented the ticket (`await`).
class TokenLedger {
 public:
  /// The largest number of pending tickets for the participants of one certificate, which are
  /// identified by the first six octets of the prefix (DDS-Security 1.2, clause 10.3.3). Enough for
  /// the 128 readers and 128 writers of two participants.
  static constexpr std::size_t kMaxPending = 16384;
  /// The limit for all senders with an unproven prefix, which can name any prefix. Each has a share
  /// like that of a certificate, but at most as much as is left for others, so that a further
  /// sender finds some space.
  static constexpr std::size_t kMaxUnproven = 4 * kMaxPending;
  /// Additional space of a certificate for the few tokens of participants and builtin endpoints,
  /// without which nothing else works.
  static constexpr std::size_t kReserved = 2048;
  /// How long an entry stays after its exchange has ended, or after the host has acknowledged its
  /// message: the host's five minutes, and the time that a message may wait in its queue. Before
  /// that, the host may delay messages for any time, until a missing one comes.
  static constexpr std::chrono::seconds kMemory{360};

  TokenLedger() = default;
  TokenLedger(const TokenLedger&) = delete;
  TokenLedger& operator=(const TokenLedger&) = delete;

  /// How long the host certainly keeps a ticket that it cannot use: five minutes, less a margin for
  /// differences of clocks.
  static constexpr std::chrono::seconds kHostKeeps{290};

  /// How long the host may take to present a ticket after the endpoints are matched.
  static constexpr std::chrono::milliseconds kComing{50};

  /// Records a message that passed check_usable. Within one exchange, the host takes the numbers of
  /// messages in order, each once. `are_builtin_matched` is true if the host has matched all
  /// builtin endpoints of sender and receiver. Error: crypto_tokens_crowded.
  Result<TokenDecision> note(const TokenMessage& message, const TokenSender& sender,
                             bool are_builtin_matched, std::chrono::nanoseconds now);

  /// Notes that the host has taken all messages of that exchange below `next`. `now`, here and
  /// below, is Clock::monotonic.
  void acknowledged(std::uint64_t exchange, std::uint64_t next, std::chrono::nanoseconds now);

  /// Notes that the sender of that exchange has left, or will authenticate again.
  void end(std::uint64_t exchange, std::chrono::nanoseconds now);

  /// Notes that the host has matched two endpoints and waits for tokens of that exchange. Tokens
  /// that come then find space beyond kMaxPending.
  void await(std::uint64_t exchange, const TokenKey& key, std::chrono::nanoseconds now);

  /// True if tokens of that exchange, which still goes on, were dropped since the last call. Either
  /// they were hidden from the host because of a ticket that it can no longer have; or they are
  /// awaited although the host took their ticket more than kHostKeeps before. Call it once a
  /// second.
  bool poll_stranded(std::uint64_t exchange, std::chrono::nanoseconds now);

  struct StoredTokens {
    Guid remote;                     ///< the sender of the tokens
    std::vector<spi::Token> tokens;  ///< empty if they came before the user's exchange
  };
  /// Returns the newest tokens for the two endpoints of the ticket that the host presents and then
  /// no longer has. Empty if `tokens` has no ticket that is still valid. The caller wipes the
  /// result. The host may present a ticket of a session that has ended, and takes no other
  /// afterwards. So the tokens of the present session go to `user` as soon as they come.
  std::optional<StoredTokens> redeem(std::span<const spi::Token> tokens, const TicketUser& user);

  /// Returns the number of all entries, for tests.
  std::size_t size() const;
  /// Returns the number of entries for which the host may hold tickets, for tests.
  std::size_t pending() const;

 private:
  using Key = TokenKey;
  /// The order of a message among all that came for two endpoints.
  struct Age {
    std::uint64_t exchange;
    std::uint64_t number;
    auto operator<=>(const Age&) const = default;
  };
  struct Entry {
    Age passed;  ///< the message with which the host got its ticket
    Age newest;  ///< the message with the stored tokens
    std::uint64_t account;
    std::optional<std::chrono::nanoseconds> matched_since = {};
    bool is_pending = true;
    std::optional<TicketUser> awaited_by = {};
    std::chrono::nanoseconds passed_at = {};
    bool is_lost = false;  ///< the host dropped its ticket unused, in the exchange of both messages
    Ticket ticket;
    PackedTokens tokens;
  };
  using Entries = std::map<Key, Entry>;
  /// The counts for the participants of one certificate, or for one exchange whose peer proved no
  /// prefix.
  struct Account {
    std::size_t pending = 0;
    std::size_t all = 0;
  };
  struct EndedExchange {
    std::chrono::nanoseconds at;
    std::uint64_t exchange;
  };
  /// The acknowledgments within one kSpan.
  struct AcknowledgmentRecord {
    std::chrono::nanoseconds since;
    std::uint64_t exchange;
    std::uint64_t next;
  };
  static constexpr std::chrono::seconds kSpan{10};
  /// The messages of an exchange that the host has taken.
  struct TakenMessages {
    std::uint64_t next = 0;                  ///< all messages below this number
    AcknowledgmentRecord* latest = nullptr;  ///< in acknowledged_; nullptr if that was too long ago
  };
  static constexpr std::uint64_t kUnproven = std::uint64_t{1} << 63;

  static std::uint64_t account_of(const Key& key, const TokenSender& sender);
  static TokenDecision of_held(Entry& entry, const TokenMessage& message, const Age& age);
  static bool is_given_up(const Key& key, Entry& entry, bool are_builtin_matched,
                          std::chrono::nanoseconds now);
  Status check_room(const Key& key, const TokenSender& sender);
  void add(const Key& key, Entry fresh);
  Ticket fresh_ticket();
  void remove_pending(Entry& entry);
  void forget_old(std::chrono::nanoseconds now);
  /// True if the host ignores that message when it comes again.
  bool has_taken(const Age& age) const;
  /// Drops tokens of an exchange, in messages below `next`, that the host never used.
  void forget_unused(std::uint64_t exchange, std::uint64_t next);
  void forget_used(const Key& key, const TokenSender& sender);
  /// Returns the first entry of an exchange; the end if there is none.
  Entries::iterator first_of(std::uint64_t exchange);
  /// The state of tokens that the host waits for.
  enum class Fate : std::uint8_t { lost, undecided, not_here };
  Fate fate_of(std::uint64_t exchange, const Key& key, std::chrono::nanoseconds since);
  /// Drops the entries of awaited tokens for endpoints that the host has matched. It would already
  /// have presented a ticket for these.
  void forget_awaited(std::uint64_t exchange, std::chrono::nanoseconds now);
  /// Notes that the host has dropped the ticket, although it may still match the endpoints.
  void note_lost(Entries::iterator entry);
  /// Erases an entry for which the host can no longer have a ticket.
  void give_up(Entries::iterator entry);
  void erase(Entries::iterator entry);

  mutable std::mutex mutex_;
  Entries entries_;
  std::set<std::pair<std::uint64_t, const Key*>> by_exchange_;  // exchange of Entry::passed
  std::deque<EndedExchange> ended_;                             // in the order in which they ended
  std::deque<AcknowledgmentRecord> acknowledged_;               // in order of time
  std::map<std::uint64_t, TakenMessages> taken_;                // by exchange
  std::map<Ticket, Entries::iterator> tickets_;
  std::map<std::uint64_t, Account> accounts_;
  std::set<std::uint64_t> stranded_;  // exchanges
  AwaitedTokens awaited_;
  std::size_t unproven_pending_ = 0;
  std::uint64_t next_ticket_ = 1;
};

/// Overwrites the values of tokens before they are dropped.
void wipe_tokens(std::span<spi::Token> tokens);

}  // namespace ddssec::cryptography
