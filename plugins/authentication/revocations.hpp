// Ends identities that are named by a revocation list which arrived while participants run, and
// peers whose CA was removed from the CA file.
#pragma once

#include <memory>
#include <vector>

#include "base/plugin_services.hpp"
#include "plugins/authentication/identity_table.hpp"

namespace ddssec::authentication {

/// What renewed documents revoke. It is found first, and applied to the table afterwards.
struct Revocations {
  /// Local and remote identities in use that must be revoked.
  std::vector<IdentityTable::RevokedIdentity> identities;
  struct Judgement {
    std::shared_ptr<OwnIdentity> by;
    std::uint64_t renewal;
    /// Call it after the identities were marked in the table.
    void note_applied() const { by->note_applied(renewal); }
  };
  std::vector<Judgement> judgements;
};

/// Checks the revocation lists of one local identity, or of all (nil). Raises an event for each
/// file with newer lists, or with lists that cannot be used. Judges authenticated peers by new
/// lists, and by CAs that renew_identities has taken. Does not mark any identity.
Revocations find_revocations(IdentityTable& table, spi::IdentityHandle local, TrustStores& stores,
                             const PluginServices& services);

}  // namespace ddssec::authentication
