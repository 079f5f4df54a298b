#include "plugins/authentication/revocations.hpp"

#include <optional>

#include "plugins/authentication/listed_identities.hpp"

namespace ddssec::authentication {
namespace {

using OwnIdentityEntry = IdentityTable::OwnIdentityEntry;

// Returns the reason why the identity must be revoked: it is on a list and its verification fails,
// even if that is only because memory ran out. A peer that is on no list stays until its expiry or
// its next handshake.
std::optional<Error> refusal(const pki::Certificate& certificate, const TrustStore& trust,
                             const OwnIdentity& whose, WallTime now) {
  if (!trust.is_on_any_list(certificate)) return std::nullopt;
  const auto verdict = trust.verify(certificate, now);
  if (verdict) return std::nullopt;
  const auto& error = verdict.error();
  return Error(error.code(), {.document = whose.revocation_list_path(),
                              .field = error.details().field,
                              .found = "serial number " + certificate.serial(),
                              .note = "it is in use, and cut off"});
}

// True for errors that are only about time or lists. The verifier first decides whether the path
// ends at a trusted CA, so these errors mean that it does. They have events of their own.
bool is_about_time_or_lists(Code code) {
  switch (code) {
    case Code::certificate_expired:
    case Code::certificate_not_yet_valid:
    case Code::certificate_revoked:
    case Code::crl_missing:
    case Code::crl_expired:
    case Code::crl_not_yet_valid:
      return true;
    default:
      return false;
  }
}

// Returns the reason why a peer must leave after CAs were removed from the file: no remaining CA
// issued its certificate, or ours that it knows. For a peer that stays, the end of the session is
// computed again.
std::optional<Error> withdrawal(IdentityTable& table, const IdentityTable::AuthenticatedPeer& peer,
                                const OwnIdentity& whose, const PluginServices& services) {
  const auto now = services.clock.calendar_seconds();
  const auto verdict = whose.peer_trust()->verify(peer.latest(), now);
  if (!verdict && is_about_time_or_lists(verdict.error().code())) return std::nullopt;
  if (!verdict) {
    auto why = follow_renewal_list(table, peer, whose, services);
    if (!why) return std::nullopt;
    why->document = whose.peer_authorities_path();
    why->expected = "a certificate of " + whose.peer_authorities();
    const bool is_ours = !why->hint.empty();
    if (!is_ours && !why->note.empty()) why->note = "; " + why->note;
    if (!is_ours) why->note = "serial number " + peer.latest().serial() + why->note;
    return Error(Code::identity_ca_withdrawn, *std::move(why));
  }
  if (const auto own = whose.verify(peer.own, now))
    table.set_verified_again(peer.handle, {*verdict, *own});
  return std::nullopt;
}

void poll_lists(const OwnIdentityEntry& local, TrustStores& stores,
                const PluginServices& services) {
  const auto renewed = local.identity->renew_revocation_lists(stores, services.clock);
  const auto us = our_name(local.identity->guid());
  if (!renewed) return services.events.raise(event_about(us, renewed.error()));
  if (!*renewed) return;
  services.events.raise(
      event_about(us, Error(Code::crl_renewed, {.document = local.identity->revocation_list_path(),
                                                .found = local.identity->revocation_lists()})));
}

// Returns the same for a peer whose session goes on with a later certificate. The certificate of
// its handshake may have expired since, but must not have been revoked.
std::optional<Error> refusal(const IdentityTable::AuthenticatedPeer& peer, const TrustStore& trust,
                             const OwnIdentity& whose, WallTime now) {
  auto reason = refusal(peer.latest(), trust, whose, now);
  if (reason || !peer.listed) return reason;
  reason = refusal(peer.certificate, trust, whose, now);
  const bool has_expired = reason && reason->code() == Code::certificate_expired;
  return has_expired ? std::nullopt : std::move(reason);
}

void add_revocations(IdentityTable& table, const OwnIdentityEntry& local, bool by_other_authorities,
                     const PluginServices& services, Revocations& out) {
  const auto now = services.clock.calendar_seconds();
  // This waits for handshake steps that began under the former lists, so that no peer authenticates
  // under these after the judgement.
  for (const auto& pair : table.pairs_of(local.handle)) const std::scoped_lock wait(pair->mutex);
  const auto trust = local.identity->peer_trust();
  if (auto reason = refusal(local.identity->certificate(), *trust, *local.identity, now))
    out.identities.push_back({local.handle, our_name(local.identity->guid()), *std::move(reason)});
  for (auto& peer : table.authenticated_with(local.handle)) {
    std::optional<Error> reason;
    if (by_other_authorities) reason = withdrawal(table, peer, *local.identity, services);
    if (!reason) reason = refusal(peer, *trust, *local.identity, now);
    if (reason) out.identities.push_back({peer.handle, std::move(peer.name), *std::move(reason)});
  }
}

}  // namespace

Revocations find_revocations(IdentityTable& table, spi::IdentityHandle which, TrustStores& stores,
                             const PluginServices& services) {
  Revocations out;
  for (const auto& local : table.locals(which)) {
    poll_lists(local, stores, services);
    if (auto reason = local.identity->ocsp_revoked())
      out.identities.push_back(
          {local.handle, our_name(local.identity->guid()), *std::move(reason)});
    if (const auto unapplied = local.identity->unapplied_renewal()) {
      add_revocations(table, local, unapplied->authorities, services, out);
      out.judgements.push_back({local.identity, unapplied->renewal});
    }
  }
  return out;
}

}  // namespace ddssec::authentication
