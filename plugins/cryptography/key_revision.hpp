// Key revisions (DDS-Security 1.2 9.5.1.6, 10.5.2.2): new salt and sender key under the same key
// id, so that a participant that gets no more keys cannot read on.
#pragma once

#include <chrono>

#include "plugins/cryptography/entities.hpp"
#include "plugins/spi/cryptography.hpp"

namespace ddssec::cryptography {

using spi::KeyRevision;

inline constexpr KeyRevision kLastKeyRevision = 0xffffff;

/// The first three octets of a transformation kind.
KeyRevision revision_of(TransformKind kind);
TransformKind with_revision(TransformKind kind, KeyRevision revision);
/// 0 is never used again.
constexpr KeyRevision next_revision(KeyRevision revision) {
  return revision == kLastKeyRevision ? 1 : revision + 1;
}
/// Numbers come round: half of them are later than any.
bool is_later(KeyRevision revision, KeyRevision than);

/// How long a remote's former keys count from the arrival of its new ones: it may send with them
/// until all have those (a host's patience is shorter), and messages are on their way.
inline constexpr auto kFormerKeyLife = std::chrono::seconds(10);
/// How many revisions besides the newest count at a time.
inline constexpr std::size_t kMostFormerRevisions = 4;

/// Lets what a remote entity had until now count beside its new keys if these revise it; other keys
/// make an end of it. Error: key_revision_stale.
Status inherit(RemoteKeys& next, const RemoteKeys* present, std::chrono::nanoseconds now);

/// Do these follow the present ones as a later revision does?
bool is_later_revision(const RemoteKeys& next, const RemoteKeys& present);

/// The same keys without former ones whose time is over.
std::unique_ptr<RemoteKeys> without_ended(const RemoteKeys& keys, std::chrono::nanoseconds now);

/// Under a ReadGuard: the former key of that kind, or nullptr.
ReceiveKey* former_key(const RemoteKeys& keys, KeyLevel level, TransformKind kind,
                       std::chrono::nanoseconds now);

}  // namespace ddssec::cryptography
