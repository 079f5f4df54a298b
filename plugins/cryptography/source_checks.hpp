// Who speaks in what was decrypted. A key proves its owner, not what the plaintext says of itself:
// a host that believes the plaintext (Cyclone DDS) gets only what names the owner of the key.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "plugins/cryptography/fragment_walks.hpp"

namespace ddssec::cryptography {

/// How much of a protected message's content its sender may say, and what ended it.
struct SenderPart {
  std::size_t size;  ///< octets from the beginning; all of them if nothing ended it
  /// info_source_mismatch, secure_group_malformed, or one of check_builtin_source
  std::optional<Error> ended;
  std::optional<GuidPrefix> named = {};  ///< by the INFO_SRC that ended it
  /// Where fragments of discovery begin that must come again: the host must not see them.
  std::vector<std::size_t> early = {};
  /// Where the parameter ids of type information stand (type_information.hpp), except within groups
  /// that are signed by themselves.
  std::vector<std::uint32_t> types = {};
  /// Where requests and replies of type lookup begin.
  std::vector<std::size_t> lookups = {};
};

/// Walks the submessages of a protected message as Cyclone DDS does. `content` is what follows the
/// RTPS header. The sender's part ends before an INFO_SRC that names another participant, unless
/// both prefixes begin with the same six octets: these are bound to the certificate's subject
/// (DDS-Security 9.3.3), and Cyclone DDS puts what the participants of one process say into one
/// message. It also ends before discovery or liveliness, in the clear inside of the message, that
/// speaks of another than the last INFO_SRC names (builtin_checks.hpp). Nothing is allocated unless
/// something ended it, or there are fragments of discovery, type information or type
/// lookups.
SenderPart part_of_sender(BytesView content, const GuidPrefix& sender, DiscoveryOfPeers& peers);

/// Checks one decrypted submessage of a writer. What the volatile secure writer sends must be
/// protected by the key exchange, and nothing else may be. A token message must name as its source,
/// twice, the participant at the other end of the key exchange; without `peer` (another vendor's
/// authentication) both must at least agree. It must be data, not a key, and whole: honest ones
/// have less than 1 kB, and the host would keep the fragments of one that never ends. Errors:
/// submessage_not_of_sender, token_source_mismatch, token_source_unreadable.
Status check_token_source(BytesView submessage, bool is_key_exchange,
                          const std::optional<GuidPrefix>& peer);

}  // namespace ddssec::cryptography
