// Key tokens, from their message until the host comes with them. Cyclone DDS holds tokens back
// until their endpoints are matched, as many as come, for five minutes each. If tokens for the same
// two endpoints come again in that time, it corrupts its memory. So it gets tickets instead of
// tokens.
#pragma once

#include <array>
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
#include "plugins/cryptography/data_piece.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

/// A key token message, as far as the ledger is concerned.
struct TokenMessage {
  Guid remote;           ///< whose keys: a participant or an endpoint
  Guid local;            ///< the receiver
  std::uint64_t number;  ///< writerSN
  bool is_of_reader;     ///< datareader_crypto_tokens
  std::vector<spi::Token> tokens;
  std::size_t class_at;   ///< where in the payload the text of message_class_id begins
  std::size_t tokens_at;  ///< where in the payload the sequence of tokens begins
};

/// Of a piece that passed check_token_source. Nothing where no tokens begin. All of them must be in
/// this piece: who sends them in fragments hides which they are. Errors: token_source_unreadable,
/// also for tokens of more than kMostTokenOctets, for an endpoint's that do not name one of the
/// sender's, and for a number from kGreatestNumber on: Cyclone DDS takes the greatest of all before
/// those that come first.
Result<std::optional<TokenMessage>> read_token_message(const DataPiece& piece);

/// Whether the host could use what the message brings once its endpoints are matched: key material,
/// as much as one may have, between a writer and a reader or between two participants. The host
/// would keep anything. Errors: token_source_unreadable (no two such entities exchange keys),
/// crypto_token_count, those of read_crypto_token.
Status check_usable(const TokenMessage& message);

inline constexpr std::uint64_t kGreatestNumber = std::uint64_t{1} << 62;

/// Of all tokens of one message, names and class ids included: three times what two keys with
/// receiver keys need.
inline constexpr std::size_t kMostTokenOctets = 1024;

/// A writer may have one key for both levels, or a key for each (DDS-Security 9.5.2.1).
inline constexpr std::size_t kMostTokensPerEndpoint = 2;

/// What the host gets instead of key material, and comes back with.
struct Ticket {
  std::array<std::uint8_t, 16> octets;
  auto operator<=>(const Ticket&) const = default;
};

/// A match for which the host comes with a ticket, or came with one of a session that had ended.
struct TicketUser {
  std::uint64_t exchange = 0;  ///< the present one with the peer; 0: there is none
  std::int64_t local = 0;      ///< crypto handles of our endpoint and the peer's
  std::int64_t remote = 0;
  bool operator==(const TicketUser&) const = default;
};

/// Who sent a message.
struct TokenSender {
  std::uint64_t exchange;  ///< tells one authentication from the next; later ones are greater
  bool is_proven = true;   ///< authentication told us the prefix that the message names
};

/// What becomes of a message.
struct Passage {
  enum class Kind : std::uint8_t {
    ticket,    ///< it goes to the host, with the ticket in it
    hidden,    ///< it goes to the host as a class that the host does not know
    repeated,  ///< hidden, since the host holds a ticket of the same exchange
    later,     ///< it is not accepted yet, and will be sent again
    awaited,   ///< hidden; the ticket is for `user`, which the host believes to have keys
  };
  Kind kind;
  Ticket ticket = {};
  TicketUser user = {};
  bool operator==(const Passage&) const = default;
};

/// Writes the ticket over the first binary value of a message that read_token_message read, and
/// zeros over all others.
void write_ticket(const Ticket& ticket, const TokenMessage& message, const DataPiece& piece,
                  MutableBytes payload);

/// The key material of usable tokens, in one block and without what is the same in all. Wiped when
/// it goes.
class PackedTokens {
 public:
  PackedTokens() = default;
  explicit PackedTokens(std::span<const spi::Token> tokens);
  PackedTokens(PackedTokens&&) noexcept = default;
  PackedTokens& operator=(PackedTokens&& other) noexcept;
  ~PackedTokens() { wipe(octets_); }

  std::vector<spi::Token> tokens() const;

 private:
  Bytes octets_;  ///< for each token its length, one octet, and so many octets
};

/// Keeps the tokens that come for two endpoints, and gives the host a ticket for them. Any number
/// of threads.
///
/// The host holds one ticket for two endpoints at a time. Tokens that come while it does replace
/// the ones kept here, and the host does not see them. It names no GUIDs when it comes back: the
/// ticket tells which two endpoints it means.
///
/// A message that was opened may still not have reached the host. When its sender authenticates
/// anew, the host may hold the former ticket or not. It drops those of a participant with the
/// participant. Those of builtin endpoints it uses as soon as it matches them; tokens wait for
/// that. Of other endpoints nothing is known for six minutes: if the host does not come in that
/// time, it never had the ticket, and what came since then must come again in a further session.
/// It is known sooner if the host has matched the two meanwhile: it would have come (`await`).
class TokenLedger {
 public:
  /// Of one certificate's participants, which are told by the first six octets of the prefix
  /// (DDS-Security 9.3.3). As many as 128 readers and 128 writers of two participants have.
  static constexpr std::size_t kMostPending = 16384;
  /// Of all senders whose prefix is not proven, which can name any. Each has a share like that of a
  /// certificate, but no more than is left for others: so a further one finds some.
  static constexpr std::size_t kMostUnproven = 4 * kMostPending;
  /// More of a certificate's, for the few that participants and builtin endpoints have: without
  /// these nothing else works.
  static constexpr std::size_t kReserved = 2048;
  /// After an exchange has ended, or the host has acknowledged a message of it: the host's five
  /// minutes, and what a message may wait in its queue. Before that the host may hold messages back
  /// for any time, until one that is missing comes.
  static constexpr std::chrono::seconds kMemory{360};

  TokenLedger() = default;
  TokenLedger(const TokenLedger&) = delete;
  TokenLedger& operator=(const TokenLedger&) = delete;

  /// How long the host surely keeps a ticket that it has no use for: five minutes, less what clocks
  /// may differ.
  static constexpr std::chrono::seconds kHostKeeps{290};

  /// How long the host may need, once endpoints are matched, to come with a ticket for them.
  static constexpr std::chrono::milliseconds kComing{50};

  /// Of a message that check_usable let pass, whose tokens it wipes. Within one exchange, the host
  /// takes the numbers of messages in order and each once.
  /// `are_builtin_matched`: the host has matched all builtin endpoints of sender and receiver.
  /// Error: crypto_tokens_crowded.
  Result<Passage> note(const TokenMessage& message, const TokenSender& sender,
                       bool are_builtin_matched, std::chrono::nanoseconds now);

  /// The host has taken all messages of that exchange below `next`.
  void acknowledged(std::uint64_t exchange, std::uint64_t next, std::chrono::nanoseconds now);

  /// The sender of that exchange is gone, or will authenticate anew.
  void end(std::uint64_t exchange, std::chrono::nanoseconds now);

  /// The host has matched two endpoints and waits for tokens of that exchange. Those that come now
  /// find room beyond kMostPending.
  void await(std::uint64_t exchange, const TokenKey& key, std::chrono::nanoseconds now);

  /// Whether tokens of that exchange, which goes on, were given up since the last call: hidden from
  /// the host because of a ticket that it cannot have any more, or awaited, though the host took
  /// their ticket more than kHostKeeps before. To be called once a second.
  bool take_stranded(std::uint64_t exchange, std::chrono::nanoseconds now);

  struct Held {
    Guid remote;                     ///< whose tokens
    std::vector<spi::Token> tokens;  ///< none, if they came before the user's exchange
  };
  /// For tokens that the host came back with, and holds no longer: the newest for the two endpoints
  /// of their ticket. Nothing if there is no ticket in them that is still good. The caller wipes
  /// them. The host may come with a ticket of a session that has ended, and takes no other after
  /// it: so the tokens of the present session go to the user as soon as they come.
  std::optional<Held> redeem(std::span<const spi::Token> tokens, const TicketUser& user);

  /// For tests: all that is remembered.
  std::size_t size() const;
  /// For tests: of that, what the host may hold tickets for.
  std::size_t pending() const;

 private:
  using Key = TokenKey;
  /// A message's place among all that came for two endpoints.
  struct Age {
    std::uint64_t exchange;
    std::uint64_t number;
    auto operator<=>(const Age&) const = default;
  };
  struct Entry {
    Age passed;  ///< the message that brought the host its ticket
    Age newest;  ///< the message that the tokens are of
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
  /// Of the participants of one certificate, or of one exchange whose peer proved no prefix.
  struct Account {
    std::size_t pending = 0;
    std::size_t all = 0;
  };
  struct Ended {
    std::chrono::nanoseconds at;
    std::uint64_t exchange;
  };
  /// All that was acknowledged within some seconds.
  struct Acknowledged {
    std::chrono::nanoseconds since;
    std::uint64_t exchange;
    std::uint64_t next;
  };
  static constexpr std::chrono::seconds kSpan{10};
  /// What the host has taken of an exchange.
  struct Taken {
    std::uint64_t next = 0;          ///< all below
    Acknowledged* latest = nullptr;  ///< in acknowledged_; null: that was long ago
  };
  static constexpr std::uint64_t kUnproven = std::uint64_t{1} << 63;

  static std::uint64_t account_of(const Key& key, const TokenSender& sender);
  static Passage of_held(Entry& entry, const TokenMessage& message, const Age& age);
  static bool is_given_up(const Key& key, Entry& entry, bool are_builtin_matched,
                          std::chrono::nanoseconds now);
  Status check_room(const Key& key, const TokenSender& sender);
  void add(const Key& key, Entry fresh);
  Ticket fresh_ticket();
  void no_longer_pending(Entry& entry);
  void forget_old(std::chrono::nanoseconds now);
  /// Whether the host passes over that message when it comes again.
  bool has_taken(const Age& age) const;
  /// What the host never used, of an exchange, in messages below `next`.
  void forget_unused(std::uint64_t exchange, std::uint64_t next);
  void forget_used(const Key& key, const TokenSender& sender);
  /// The first entry of an exchange; the end without one.
  Entries::iterator first_of(std::uint64_t exchange);
  /// Of tokens that the host waits for.
  enum class Fate : std::uint8_t { lost, undecided, not_here };
  Fate fate_of(std::uint64_t exchange, const Key& key, std::chrono::nanoseconds since);
  /// The host would have come with a ticket for endpoints that it has matched.
  void forget_awaited(std::uint64_t exchange, std::chrono::nanoseconds now);
  /// The host has dropped the ticket, and may yet match the endpoints.
  void note_lost(Entries::iterator entry);
  /// Erases what the host can have no ticket for any more.
  void give_up(Entries::iterator entry);
  void erase(Entries::iterator entry);

  mutable std::mutex mutex_;
  Entries entries_;
  std::set<std::pair<std::uint64_t, const Key*>>
      by_exchange_;                        // the one of the message that passed
  std::deque<Ended> ended_;                // the first ended first
  std::deque<Acknowledged> acknowledged_;  // the first first
  std::map<std::uint64_t, Taken> taken_;   // by exchange
  std::map<Ticket, Entries::iterator> tickets_;
  std::map<std::uint64_t, Account> accounts_;
  std::set<std::uint64_t> stranded_;  // exchanges
  AwaitedTokens awaited_;
  std::size_t unproven_pending_ = 0;
  std::uint64_t next_ticket_ = 1;
};

/// Before tokens that were held are given up.
void wipe_tokens(std::span<spi::Token> tokens);

}  // namespace ddssec::cryptography
