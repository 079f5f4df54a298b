#include "plugins/authentication/renewal.hpp"

#include <array>

namespace ddssec::authentication {
namespace {

using Taken = LocalIdentity::AuthoritiesTaken;

Taken renew_authorities(LocalIdentity& identity, TrustStores& stores,
                        const Environment& environment) {
  const auto us = our_name(identity.guid());
  const auto taken = identity.renew_authorities(stores, environment.clock);
  if (!taken) environment.events.raise(event_about(us, taken.error()));
  if (!taken || !taken->authorities) return {};
  environment.events.raise(event_about(
      us, Error(Code::identity_ca_renewed,
                {.document = identity.authorities_path(), .found = identity.authorities()})));
  return *taken;
}

bool renew_certificate(LocalIdentity& identity, const Environment& environment) {
  const auto renewed = identity.renew_identity(environment.clock);
  if (!renewed) environment.events.raise(event_about(our_name(identity.guid()), renewed.error()));
  return renewed && *renewed;
}

Error renewed_until(const LocalIdentity& identity, const pki::ChainValid& chain) {
  return Error(Code::identity_renewed, {.document = identity.identity_path(),
                                        .field = "notAfter",
                                        .found = to_string(chain.not_after()),
                                        .note = "serial number " + chain.certificate().serial()});
}

}  // namespace

void renew_identities(IdentityTable& table, spi::IdentityHandle which, TrustStores& stores,
                      const Environment& environment) {
  for (const auto& local : table.locals(which)) {
    auto& identity = *local.identity;
    // The CAs come first: a renewed certificate may be of a new one.
    const auto taken = renew_authorities(identity, stores, environment);
    const bool is_renewed = renew_certificate(identity, environment) || taken.identity;
    if (!is_renewed && !taken.authorities) continue;
    const auto chain = identity.verify(environment.clock.now());
    if (!chain) continue;  // it has just ended, and `expire` says so
    table.note_renewed(local.handle, *chain);
    if (is_renewed)
      environment.events.raise(
          event_about(our_name(identity.guid()), renewed_until(identity, *chain)));
  }
}

void note_documents(const IdentityTable& table, spi::IdentityHandle which,
                    const Environment& environment) {
  if (environment.documents == nullptr) return;
  for (const auto& local : table.locals(which)) {
    const auto& identity = *local.identity;
    environment.documents->note_participant(local.handle.value, identity.guid().to_string(),
                                            identity.certificate().subject());
    environment.documents->note(local.handle.value, identity.documents(), environment.clock.now());
  }
}

void forget_documents(spi::IdentityHandle local, const Environment& environment) {
  constexpr std::array kOurs = {DocumentKind::identity_certificate, DocumentKind::identity_ca,
                                DocumentKind::revocation_list};
  if (environment.documents != nullptr) environment.documents->forget(local.value, kOurs);
}

}  // namespace ddssec::authentication
