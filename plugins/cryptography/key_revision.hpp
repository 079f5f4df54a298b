// Key revisions (DDS-Security 1.2, clauses 9.5.1.6 and 10.5.2.2): new salt and sender key under the
// same key id. A participant that gets no more keys can then no longer decrypt.
#pragma once

#include <chrono>

#include "plugins/cryptography/entities.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::cryptography {

using spi::KeyRevision;

inline constexpr KeyRevision kLastKeyRevision = 0xffffff;

/// Returns the key revision of a kind: its first three octets.
KeyRevision revision_of(TransformKind kind);
TransformKind with_revision(TransformKind kind, KeyRevision revision);
/// Returns the revision after this one. Revision 0 never comes again.
constexpr KeyRevision next_revision(KeyRevision revision) {
  return revision == kLastKeyRevision ? 1 : revision + 1;
}
/// True if `revision` is later than `than`. Revisions wrap around, so half of them are later than
/// any given one.
bool is_later(KeyRevision revision, KeyRevision than);

using spi::kFormerKeyLife;
/// The largest number of valid revisions besides the newest.
inline constexpr std::size_t kMaxFormerRevisions = 4;

/// Keeps a remote entity's present keys valid beside `next` if `next` revises them. Keys that do
/// not revise them replace them at once. Error: key_revision_stale.
Status inherit(RemoteKeys& next, const RemoteKeys* present, std::chrono::nanoseconds now);

/// True if `next` is a later revision of the present keys.
bool is_later_revision(const RemoteKeys& next, const RemoteKeys& present);

/// Returns a copy of the keys without former ones that are no longer valid.
std::unique_ptr<RemoteKeys> without_ended(const RemoteKeys& keys, std::chrono::nanoseconds now);

/// The former key of that kind that is still valid; nullptr if there is none. Call it under a
/// ReadGuard.
ReceiveKey* former_key(const RemoteKeys& keys, KeyLevel level, TransformKind kind,
                       std::chrono::nanoseconds now);

}  // namespace ddssec::cryptography
