// Which key tokens the host holds back until their endpoints are matched. Cyclone DDS corrupts its
// memory when tokens come again for two endpoints while it holds the former ones, and it holds as
// many as come, for five minutes each.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <list>
#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "base/hash.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/data_piece.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

/// A key token message, as far as the ledger is concerned.
struct TokenMessage {
  Guid remote;           ///< whose keys: a participant or an endpoint
  Guid local;            ///< whom they are for
  std::uint64_t number;  ///< writerSN
  Sha256Digest tokens;   ///< see digest_of
  std::size_t class_at;  ///< where in the payload the text of message_class_id begins
};

/// Of a piece that passed check_token_source. Nothing where no tokens begin. All of them must be in
/// this piece: who sends them in fragments hides which they are. Error: token_source_unreadable.
Result<std::optional<TokenMessage>> read_token_message(const DataPiece& piece);

/// The same for the same tokens, however they travelled.
Sha256Digest digest_of(std::span<const spi::Token> tokens);

/// Notes which tokens pass to the host and which the host came back with. Any number of threads.
///
/// The host names no GUIDs when it comes back, so what it used is told by the tokens themselves. A
/// writer gives all readers of a participant the same ones unless origin is authenticated: those
/// are used once the host came back as often as they passed.
class TokenLedger {
 public:
  /// Of one certificate's participants, which are told by the first six octets of the prefix
  /// (DDS-Security 9.3.3).
  static constexpr std::size_t kMostPending = 2048;
  /// The host's five minutes, and what a message may wait in its queue.
  static constexpr std::chrono::seconds kMemory{360};

  /// May the message pass? `exchange` tells one authentication of its sender from the next: within
  /// one, the host takes each number once, so what is repeated is a retransmission.
  /// Errors: crypto_tokens_repeated, crypto_tokens_crowded.
  Status note(const TokenMessage& message, std::uint64_t exchange, std::chrono::nanoseconds now);

  /// The host came with these tokens, and holds them no longer.
  void note_used(std::span<const spi::Token> tokens);

  /// For tests: all that is remembered.
  std::size_t size() const;

 private:
  struct Key {
    Guid remote;
    Guid local;
    auto operator<=>(const Key&) const = default;
  };
  struct Entry {
    std::uint64_t exchange;
    std::uint64_t number;
    std::chrono::nanoseconds since;
    bool is_pending;
    Sha256Digest tokens;
    std::list<Key>::iterator place;
  };
  using Entries = std::map<Key, Entry>;
  /// Entries with the same tokens, and how often the host came with them.
  struct Group {
    std::vector<Key> keys;
    std::size_t used = 0;
  };
  struct Counts {
    std::size_t pending = 0;
    std::size_t all = 0;
  };
  using Subject = std::array<std::uint8_t, 6>;

  static Subject subject_of(const Key& key);
  void forget_old(std::chrono::nanoseconds now);
  void forget_used(const Subject& subject);
  void erase(Entries::iterator entry);
  void leave_group(const Key& key, const Entry& entry);

  mutable std::mutex mutex_;
  Entries entries_;
  std::list<Key> order_;  // oldest first
  std::map<Sha256Digest, Group> groups_;
  std::map<Subject, Counts> counts_;
};

}  // namespace ddssec::cryptography
