#include "plugins/authentication/revocation.hpp"

#include <optional>

namespace ddssec::authentication {
namespace {

using OurOwn = IdentityTable::OurOwn;

/// Nothing if `trust` does not call it revoked: of all else its end or its next handshake tells.
std::optional<Error> revoked(const pki::Certificate& certificate, const TrustStore& trust,
                             const LocalIdentity& whose, WallTime now) {
  if (!trust.may_be_revoked(certificate)) return std::nullopt;
  const auto verdict = trust.verify(certificate, now);
  if (verdict || verdict.error().code() != Code::certificate_revoked) return std::nullopt;
  return Error(Code::certificate_revoked, {.document = whose.revocation_list_path(),
                                           .field = verdict.error().details().field,
                                           .found = "serial number " + certificate.serial(),
                                           .note = "it is in use, and cut off"});
}

void look_at_lists(const OurOwn& local, TrustStores& stores, const Environment& environment) {
  const auto renewed = local.identity->renew_revocation_lists(stores, environment.clock);
  const auto guid = local.identity->guid().to_string();
  if (!renewed) return environment.events.raise(Event(renewed.error(), {}, guid));
  if (!*renewed) return;
  environment.events.raise(
      Event(Error(Code::crl_renewed, {.document = local.identity->revocation_list_path(),
                                      .found = local.identity->revocation_lists()}),
            {}, guid));
}

void judge(const IdentityTable& table, const OurOwn& local, WallTime now, Revocations& out) {
  // A step of a handshake that began under the former lists ends before anybody is judged.
  for (const auto& pair : table.pairs_of(local.handle)) const std::scoped_lock wait(pair->mutex);
  const auto trust = local.identity->peer_trust();
  if (auto reason = revoked(local.identity->certificate(), *trust, *local.identity, now))
    out.identities.push_back(
        {local.handle, {{}, local.identity->guid().to_string()}, *std::move(reason)});
  for (auto& peer : table.authenticated_with(local.handle))
    if (auto reason = revoked(peer.certificate, *trust, *local.identity, now))
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
