// Which endpoint a key belongs to. Cyclone DDS takes a submessage for the words of the endpoint
// that it names if any key of that endpoint's participant opened it. Every participant in the
// domain holds such keys, those of secure discovery among them, so each key is bound to its
// endpoint here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "base/ids.hpp"
#include "base/result.hpp"

namespace ddssec::cryptography {

struct RemoteEndpoint;

/// ParticipantVolatileMessageSecure (DDS-Security 7.4.5): both directions have one key.
inline constexpr EntityId kVolatileWriter{{0xff, 0x02, 0x02, 0xc3}};
inline constexpr EntityId kVolatileReader{{0xff, 0x02, 0x02, 0xc4}};

/// RTPS 9.3.1.2.
constexpr bool is_builtin(const EntityId& id) { return (id.octets[3] & 0xc0) == 0xc0; }

/// What a key token message says: `key` is that of `endpoint`.
struct KeyOwner {
  KeyId key;
  EntityId endpoint;
};

/// Reads it from the payload of a key token message that check_token_source let pass. Only the key
/// of submessages, the first, counts. Nothing for a participant's tokens, for a later fragment, and
/// where the first token cannot be read.
std::optional<KeyOwner> owner_in_tokens(BytesView payload);

/// The owners of one remote participant's keys, from its token messages until its endpoints are
/// matched, which may come later. Thread-safe.
class KeyOwners {
 public:
  /// Tokens that wait for their endpoint. The oldest goes first: a matched endpoint keeps its own.
  static constexpr std::size_t kMaxKeys = 4096;

  void note(const KeyOwner& owner);
  /// Zero: not known. Error: key_material_key_id, if two endpoints were said to have this key.
  Result<EntityId> owner_of(KeyId key) const;

 private:
  mutable std::mutex mutex_;
  std::unordered_map<std::uint32_t, EntityId> owners_;  ///< zero: of several
  std::deque<std::uint32_t> order_;
};

/// Does a submessage, opened by the key of `sender`, name the owner of that key as its sender? A
/// key of unknown owner speaks for an application's endpoints only, or, if received by a builtin
/// endpoint, for builtin ones only. Under a ReadGuard. Errors: submessage_not_of_sender,
/// secure_group_malformed.
Status check_speaker(const RemoteEndpoint& sender, BytesView plain);

}  // namespace ddssec::cryptography
