// The facts about a finished handshake that authentication knows and access control needs. Both
// plugins exchange them in the credential token of the peer, inside one process. They are never
// sent.
#pragma once

#include <optional>

#include "base/hash.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// The facts about one peer. They hold for the session that the handshake began.
struct SessionFacts {
  /// SHA-256 of the permissions document that this handshake presented to the peer. Empty with
  /// another vendor's authentication.
  std::optional<Sha256Digest> presented_permissions;
  /// True if the peer's product judges documents only during the handshake. So it keeps the session
  /// when the documents that it has seen end.
  bool peer_keeps_session = false;
  /// True if the peer runs ddssec and so may have a renewal list.
  bool peer_reads_lists = false;
};

/// Adds the facts to a token as properties that do not propagate. Their values are text, because
/// Cyclone DDS supports only text in this token.
void add_session_facts(Token& credential, const SessionFacts& facts);
/// Returns the facts in a token. Missing or malformed ones have the values of a default
/// SessionFacts.
SessionFacts session_facts_in(const Token& credential);

}  // namespace ddssec::spi
