// Ends identities that revocation lists name which came while participants run.
#pragma once

#include <memory>
#include <vector>

#include "base/event.hpp"
#include "plugins/authentication/identity_table.hpp"

namespace ddssec::authentication {

struct Revocations {
  /// Local and remote identities in use.
  std::vector<IdentityTable::Revoked> identities;
  struct Judgement {
    std::shared_ptr<LocalIdentity> by;
    std::uint64_t renewal;
    /// Call when the identities are marked.
    void note_applied() const { by->note_applied(renewal); }
  };
  std::vector<Judgement> judgements;
};

/// Looks at the lists of one local identity or (nil) of all, raises an event for each file that has
/// newer ones or cannot be used, and judges authenticated peers by lists that are new. Marks
/// none.
Revocations find_revocations(const IdentityTable& table, spi::IdentityHandle local,
                             TrustStores& stores, const Environment& environment);

}  // namespace ddssec::authentication
