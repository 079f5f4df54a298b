// Sessions that go on after the end of a certificate, because the renewal list has a later one.
#pragma once

#include <vector>

#include "base/engine_services.hpp"
#include "plugins/authentication/identity_table.hpp"

namespace ddssec::authentication {

/// Removes from `ended` the remote identities whose sessions go on, moves their ends, and raises
/// peer_renewal_listed for each peer whose certificate is followed by a listed one:
/// - The certificate of the peer has ended, and ListedRenewals::after has one for it.
/// - Ours that the peer has seen has ended, we have another one of the same key in force, which is
///   on our list, and the peer is of ddssec. If the peer has no such list, it ends the session, and
///   we follow.
/// The others say in Ended::note why a listed certificate does not count. The lists are read once
/// more before, if a peer has ended.
void follow_renewal_lists(IdentityTable& table, std::vector<IdentityTable::Ended>& ended,
                          const EngineServices& services);

/// The same for a peer whose certificate none of the CAs trusted now has issued. Returns true if
/// the session goes on.
bool follow_renewal_list(IdentityTable& table, const IdentityTable::Authenticated& peer,
                         const LocalIdentity& local, const EngineServices& services);

}  // namespace ddssec::authentication
