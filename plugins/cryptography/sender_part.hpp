// Checks the source that decrypted content names. A key proves its owner, but not the source that
// the plaintext names. A host that trusts the plaintext (Cyclone DDS) receives only content that
// names the owner of the key.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/fragment_walks.hpp"

namespace ddssec::cryptography {

/// The part of a protected message's content that its sender may send, and the reason why this part
/// ended.
struct SenderPart {
  std::size_t size;  ///< octets from the beginning; all if no reason ended it
  /// info_source_mismatch, secure_group_malformed, or one of check_builtin_source
  std::optional<Error> ended;
  std::optional<GuidPrefix> named = {};  ///< the participant named by the INFO_SRC that ended it
  /// Positions of submessages that the host must not see: discovery fragments that must come again,
  /// and samples in the clear of closed writers (DiscoveryOfPeers::is_closed).
  std::vector<std::size_t> hidden = {};
  /// The places of type information, except inside groups that are signed separately.
  std::vector<TypeInformationPlace> types = {};
  /// Positions of type lookup requests and replies.
  std::vector<std::size_t> lookups = {};
};

/// Walks the submessages of a protected message as Cyclone DDS does. `content` is the message
/// without its RTPS header.
///
/// The sender's part ends before an INFO_SRC that names another participant, unless both prefixes
/// begin with the same six octets. These octets are bound to the certificate's subject
/// (DDS-Security 1.2, clause 10.3.3), and Cyclone DDS puts the submessages of several participants
/// of one process into one message. The part also ends before an unprotected discovery or
/// liveliness submessage inside the message that concerns another participant than the last
/// INFO_SRC names (builtin_checks.hpp).
///
/// Allocates nothing unless something ended the part, or there are discovery fragments, type
/// information or type lookups.
SenderPart part_of_sender(BytesView content, const GuidPrefix& sender, DiscoveryOfPeers& peers);

/// Checks one decrypted submessage of a writer.
///
/// Messages of the volatile secure writer must be protected by the key exchange, and no others may
/// be. A token message must name as its source, twice, the participant at the other end of the key
/// exchange. Without `peer` (another vendor's authentication) the two names must at least agree.
/// The message must be data, not a key, and must be whole. Honest ones have less than 1 kB, and the
/// host would keep the fragments of a message that is never completed.
///
/// Errors: submessage_not_of_sender, token_source_mismatch, token_source_unreadable.
Status check_token_source(BytesView submessage, bool is_key_exchange,
                          const std::optional<GuidPrefix>& peer);

}  // namespace ddssec::cryptography
