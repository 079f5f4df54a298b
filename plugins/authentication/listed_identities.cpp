#include "plugins/authentication/listed_identities.hpp"

#include <expected>
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
// otherwise one that the peer may know from its list, or else the reason why there is none. The
// files of the certificate and of the list are replaced one after the other, so the listed one may
// be that before or after the one in force.
std::expected<pki::ValidChain, std::string> followed_own(const AuthenticatedPeer& peer,
                                                         const OwnIdentity& local, WallTime now) {
  if (auto seen = local.verify(peer.own, now)) return *std::move(seen);
  const auto present = local.certificate();
  const auto because = [&](std::string_view why) {
    return std::unexpected("our certificate with serial number " + peer.own.serial() +
                           ", which the peer knows, does not count any more, and " +
                           std::string(why));
  };
  if (!peer.reads_lists) return because("the peer reads no renewal list");
  if (present == peer.own) return because("ours was not renewed");
  if (pki::key_digest(present) != pki::key_digest(peer.own)) return because("our key is another");
  auto listed = local.listed_after(peer.own, now);
  if (!listed) return because("our renewal list has no valid one of ours for its key");
  return *std::move(listed);
}

Error listed_event(const pki::ValidChain& chain) {
  return Error(Code::peer_renewal_listed,
               {.document = "certificate of " + chain.certificate().subject(),
                .field = "notAfter",
                .found = to_string(chain.not_after()),
                .note = "serial number " + chain.certificate().serial()});
}

}  // namespace

std::optional<ErrorDetails> follow_renewal_list(IdentityTable& table, const AuthenticatedPeer& peer,
                                                const OwnIdentity& local,
                                                const PluginServices& services) {
  const auto now = services.clock.calendar_seconds();
  const auto found = followed_peer(peer, local, now);
  if (!found.peer)
    return ErrorDetails{.field = peer.latest().subject(),
                        .found = "issuer " + peer.latest().issuer(),
                        .note = found.why_not};
  const auto own = followed_own(peer, local, now);
  if (!own)
    return ErrorDetails{.field = "our " + peer.own.subject(),
                        .found = "issuer " + peer.own.issuer(),
                        .note = own.error(),
                        .hint =
                            "the peer authenticates again at once; to keep its session the "
                            "next time, distribute the renewal list with our certificate "
                            "before the former CA leaves: ddssec crl distribute FOLDER --ca "
                            "CA"};
  table.extend_by_renewal_list(peer.handle, {*found.peer, *own});
  if (found.by_list) services.events.raise(event_about(peer.name, listed_event(*found.peer)));
  return std::nullopt;
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
    auto not_followed = follow_renewal_list(table, *peer, local, services);
    if (not_followed) one.note = std::move(not_followed->note);
    return !not_followed;
  });
}

}  // namespace ddssec::authentication
