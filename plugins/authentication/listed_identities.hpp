// Sessions that go on after the end of a certificate, because the renewal list has a later one.
#pragma once

#include <optional>
#include <vector>

#include "base/plugin_services.hpp"
#include "plugins/authentication/identity_table.hpp"

namespace ddssec::authentication {

/// Removes from `ended` the remote identities whose sessions go on, moves their ends, and raises
/// peer_renewal_listed for each peer whose certificate is followed by a listed one. A session goes
/// on in two cases:
/// - The peer's certificate has ended, and ListedRenewals::after has one for it.
/// - Our certificate that the peer has seen has ended, another one of the same key is in force, one
///   of that key is on our list, and the peer runs ddssec. If the peer has no such list, it ends
///   the session, and we follow.
/// For the others EndedIdentity::note has the reason why a listed certificate, the peer's or ours,
/// does not count. If a peer has ended, the lists are read once more before.
void follow_renewal_lists(IdentityTable& table, std::vector<IdentityTable::EndedIdentity>& ended,
                          const PluginServices& services);

/// As follow_renewal_lists, for a peer whose certificate was issued by none of the CAs trusted now.
/// Returns nothing if the session goes on. Otherwise returns the certificate that does not count,
/// the peer's or ours (with a hint), and a note why no listed one does, which may be blank.
std::optional<ErrorDetails> follow_renewal_list(IdentityTable& table,
                                                const IdentityTable::AuthenticatedPeer& peer,
                                                const OwnIdentity& local,
                                                const PluginServices& services);

}  // namespace ddssec::authentication
