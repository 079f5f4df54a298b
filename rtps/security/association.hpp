// The state that is shared with an authenticated peer.
#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>

#include "plugins/spi/access_control.hpp"
#include "plugins/spi/session_reset.hpp"
#include "rtps/budget/work_budget.hpp"
#include "rtps/reliability/stateful_reader.hpp"
#include "rtps/security/cleanup.hpp"
#include "rtps/security/early_tokens.hpp"
#include "rtps/security/governance_of_peer.hpp"
#include "rtps/security/peer_handshake.hpp"
#include "rtps/security/waiting_tokens.hpp"

namespace ddssec::rtps {

/// A handle of access control, and the cleanup that returns it.
struct PeerPermissions {
  spi::PermissionsHandle handle = {};
  Cleanup give_back = {};
};

/// The state that is shared with a peer that proved its identity. The members are destroyed in
/// reverse order: the keys first, then the permissions and the identity that the keys were created
/// for.
struct Association {
  /// The finished handshake; another one may run at the same time.
  std::unique_ptr<PeerHandshake> handshake = {};
  PeerPermissions permissions = {};
  std::string subject = {};  ///< of its certificate
  Cleanup place = {};        ///< returns its share of the places for its certificate
  /// For judging the peer's renewed documents; see DocumentRenewal.
  WorkBudget renewal_judgements{6, std::chrono::seconds(5), {}};
  GovernanceOfPeer governance = {};
  MonotonicTime former_keys_end = kNever;  ///< of the keys that it has revised
  /// The peer has revised its keys. Before that, another participant could end the peer's endpoints
  /// in its name. So keys that are missing now are requested.
  bool has_revised = false;
  /// For telling all endpoints that the peer has revised its keys of messages. That takes time for
  /// each of them, and for each writer of the peer that has left.
  WorkBudget revisions{4, std::chrono::seconds(1), {}};
  bool is_revision_untold = false;  ///< the endpoints are told of it within a second
  EarlyTokens early = {};
  WaitingTokens waiting = {};
  std::unique_ptr<StatefulReader> volatile_reader = {};
  std::unique_ptr<StatefulWriter> volatile_writer = {};
  /// Makes the peer begin a new session if it keeps this one. Empty for a peer of another product.
  std::optional<spi::ResetToken> reset = {};
  Cleanup keys = {};  ///< removes them from the keyring
};

}  // namespace ddssec::rtps
