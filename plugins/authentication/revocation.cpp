#include "plugins/authentication/revocation.hpp"

#include <optional>

namespace ddssec::authentication {
namespace {

using OurOwn = IdentityTable::OurOwn;

/// The reason why the identity must be revoked: it is on a list and its verification fails, even if
/// only because memory ran out. A peer that is on no list stays: its expiry or its next handshake
/// decides.
std::optional<Error> refusal(const pki::Certificate& certificate, const TrustStore& trust,
                             const LocalIdentity& whose, WallTime now) {
  if (!trust.may_be_revoked(certificate)) return std::nullopt;
  const auto verdict = trust.verify(certificate, now);
  if (verdict) return std::nullopt;
  const auto& error = verdict.error();
  return Error(error.code(), {.document = whose.revocation_list_path(),
                              .field = error.details().field,
                              .found = "serial number " + certificate.serial(),
                              .note = "it is in use, and cut off"});
}

void look_at_lists(const OurOwn& local, TrustStores& stores, const Environment& environment) {
  const auto renewed = local.identity->renew_revocation_lists(stores, environment.clock);
  const auto us = our_name(local.identity->guid());
  if (!renewed) return environment.events.raise(event_about(us, renewed.error()));
  if (!*renewed) return;
  environment.events.raise(
      event_about(us, Error(Code::crl_renewed, {.document = local.identity->revocation_list_path(),
                                                .found = local.identity->revocation_lists()})));
}

void judge(const IdentityTable& table, const OurOwn& local, WallTime now, Revocations& out) {
  // Waits for handshake steps that began under the former lists, so that no peer authenticates
  // under them after the judgement.
  for (const auto& pair : table.pairs_of(local.handle)) const std::scoped_lock wait(pair->mutex);
  const auto trust = local.identity->peer_trust();
  if (auto reason = refusal(local.identity->certificate(), *trust, *local.identity, now))
    out.identities.push_back({local.handle, our_name(local.identity->guid()), *std::move(reason)});
  for (auto& peer : table.authenticated_with(local.handle))
    if (auto reason = refusal(peer.certificate, *trust, *local.identity, now))
      out.identities.push_back({peer.handle, std::move(peer.name), *std::move(reason)});
}

}  // namespace

Revocations find_revocations(const IdentityTable& table, spi::IdentityHandle which,
                             TrustStores& stores, const Environment& environment) {
  Revocations out;
  for (const auto& local : table.locals(which)) {
    look_at_lists(local, stores, environment);
    if (const auto renewal = local.identity->unapplied_renewal()) {
      judge(table, local, environment.clock.now(), out);
      out.judgements.push_back({local.identity, *renewal});
    }
  }
  return out;
}

}  // namespace ddssec::authentication
