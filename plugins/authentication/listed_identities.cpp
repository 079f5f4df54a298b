#include "plugins/authentication/listed_identities.hpp"

#include <set>

#include "pki/key_digests.hpp"
#include "plugins/authentication/renewal.hpp"

namespace ddssec::authentication {
namespace {

using AuthenticatedPeer = IdentityTable::AuthenticatedPeer;

// The certificates with which a session goes on now.
struct FollowedCertificates {
  std::optional<pki::ValidChain> peer = {};
  bool by_list = false;  // true if the list has the peer's certificate
  std::string why_not = {};
};

// Returns the proof of the peer: its latest certificate if that is valid, otherwise the one that
// follows on the list.
FollowedCertificates followed_peer(const AuthenticatedPeer& peer, const OwnIdentity& local,
                                   WallTime now) {
  const auto trust = local.peer_trust();
  if (auto latest = trust->verify(peer.latest(), now)) return {.peer = *std::move(latest)};
  if (local.ocsp_policy() == OcspPolicy::hard) return {};
  auto found = local.listed().after({peer.certificate, peer.latest()}, *trust, now);
  return {std::move(found.chain), true, std::move(found.why_not)};
}

// Returns the proof of our own certificate: the one that the peer has seen if that is valid,
// otherwise one that the peer may know from its list. The files of the certificate and of the list
// are replaced one after the other, so the listed one may be that before or after the one in force.
std::optional<pki::ValidChain> followed_own(const AuthenticatedPeer& peer, const OwnIdentity& local,
                                            WallTime now) {
  if (auto seen = local.verify(peer.own, now)) return *std::move(seen);
  const auto present = local.certificate();
  if (!peer.reads_lists || present == peer.own ||
      pki::key_digest(present) != pki::key_digest(peer.own))
    return std::nullopt;
  return local.listed_after(peer.own, now);
}

Error listed_event(const pki::ValidChain& chain) {
  return Error(Code::peer_renewal_listed,
               {.document = "certificate of " + chain.certificate().subject(),
                .field = "notAfter",
                .found = to_string(chain.not_after()),
                .note = "serial number " + chain.certificate().serial()});
}

// Lets a session go on, if it can. Returns nothing if it goes on, and otherwise a note about the
// peer's certificate, which may be blank.
std::optional<std::string> follow(IdentityTable& table, const AuthenticatedPeer& peer,
                                  const OwnIdentity& local, const PluginServices& services) {
  const auto now = services.clock.calendar_seconds();
  const auto found = followed_peer(peer, local, now);
  if (!found.peer) return found.why_not;
  const auto own = followed_own(peer, local, now);
  if (!own) return "";
  table.extend_by_renewal_list(peer.handle, {*found.peer, *own});
  if (found.by_list) services.events.raise(event_about(peer.name, listed_event(*found.peer)));
  return std::nullopt;
}

}  // namespace

bool follow_renewal_list(IdentityTable& table, const AuthenticatedPeer& peer,
                         const OwnIdentity& local, const PluginServices& services) {
  return !follow(table, peer, local, services);
}

void follow_renewal_lists(IdentityTable& table, std::vector<IdentityTable::EndedIdentity>& ended,
                          const PluginServices& services) {
  std::set<const OwnIdentity*> looked;
  std::erase_if(ended, [&](IdentityTable::EndedIdentity& one) {
    const auto peer = table.authenticated(one.handle);
    const auto pair = table.pair_of(one.handle);
    if (!peer || !pair || !table.local(pair->local_handle)) return false;
    const auto& local = *pair->local;
    if (looked.insert(&local).second) {
      local.listed().force_poll();
      poll_renewal_list(local, services);
    }
    auto why_not = follow(table, *peer, local, services);
    if (why_not) one.note = *std::move(why_not);
    return !why_not;
  });
}

}  // namespace ddssec::authentication
