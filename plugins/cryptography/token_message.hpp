// The messages that bring key tokens (DDS-Security 1.2, clause 7.3.22).
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/data_piece.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cryptography {

/// The fields of a key token message that the ledger needs.
struct TokenMessage {
  Guid remote;           ///< owner of the keys: a participant or an endpoint
  Guid local;            ///< the receiver
  std::uint64_t number;  ///< writerSN
  bool is_of_reader;     ///< datareader_crypto_tokens
  std::vector<spi::Token> tokens;
  std::size_t class_at;   ///< position of the text of message_class_id in the payload
  std::size_t tokens_at;  ///< position of the sequence of tokens in the payload
};

/// Parses a piece that passed check_token_source; empty if no tokens begin in it. All tokens must
/// be in this piece: with fragments, a sender could hide which tokens it sends. Error:
/// token_source_unreadable, also for tokens of more than kMaxTokenOctets, for an endpoint's tokens
/// that do not name an endpoint of the sender, and for numbers from kMaxNumber on: Cyclone DDS
/// handles the greatest of all numbers before those that come first.
Result<std::optional<TokenMessage>> read_token_message(const DataPiece& piece);

/// Success if the host could use the tokens once its endpoints are matched: key material, of an
/// allowed number, between a writer and a reader or between two participants. The host would store
/// any token. Errors: token_source_unreadable (no two such entities exchange keys),
/// crypto_token_count, those of read_crypto_token.
Status check_usable(const TokenMessage& message);

inline constexpr std::uint64_t kMaxNumber = std::uint64_t{1} << 62;

/// The largest number of octets of all tokens of one message, including names and class ids: three
/// times the size of two keys with receiver keys.
inline constexpr std::size_t kMaxTokenOctets = 1024;

/// A writer may have one key for both levels, or one key for each (DDS-Security 1.2,
/// clause 10.5.2.1).
inline constexpr std::size_t kMaxTokensPerEndpoint = 2;

/// A text that the host gets instead of key material, and presents later.
struct Ticket {
  std::array<std::uint8_t, 16> octets;
  auto operator<=>(const Ticket&) const = default;
};

/// Overwrites the first binary value of a message from read_token_message with the ticket, and all
/// others with zeros. If they are not where they were read, zeros replace all the tokens.
void write_ticket(const Ticket& ticket, const TokenMessage& message, const DataPiece& piece,
                  MutableBytes payload);

}  // namespace ddssec::cryptography
