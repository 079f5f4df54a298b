#include "plugins/authentication/renewal.hpp"

#include <array>

namespace ddssec::authentication {
namespace {

using AuthorityRenewal = OwnIdentity::AuthorityRenewal;

AuthorityRenewal renew_authorities(OwnIdentity& identity, TrustStores& stores,
                                   const PluginServices& services) {
  const auto us = our_name(identity.guid());
  const auto taken = identity.renew_authorities(stores, services.clock);
  if (!taken) services.events.raise(event_about(us, taken.error()));
  if (!taken || !taken->authorities) return {};
  services.events.raise(event_about(
      us, Error(Code::identity_ca_renewed,
                {.document = identity.authorities_path(), .found = identity.authorities()})));
  return *taken;
}

void renew_trusted_folder(OwnIdentity& identity, TrustStores& stores,
                          const PluginServices& services) {
  const auto us = our_name(identity.guid());
  const auto taken = identity.renew_trusted_folder(stores, services.clock);
  if (!taken) services.events.raise(event_about(us, taken.error()));
  if (!taken || !*taken) return;
  services.events.raise(event_about(
      us, Error(Code::identity_ca_renewed,
                {.document = identity.peer_authorities_path(),
                 .found = identity.peer_authorities(),
                 .note = "these are the CAs of the folder dds.sec.auth.trusted_ca_dir"})));
}

bool renew_certificate(OwnIdentity& identity, const PluginServices& services) {
  const auto renewed = identity.renew_identity(services.clock);
  if (!renewed) services.events.raise(event_about(our_name(identity.guid()), renewed.error()));
  return renewed && *renewed;
}

// A revocation of our own certificate is reported with the revocations (revocations.cpp).
void renew_ocsp_response(OwnIdentity& identity, const PluginServices& services) {
  const auto us = our_name(identity.guid());
  const auto renewed = identity.renew_ocsp_response(services.clock);
  if (!renewed && renewed.error().code() != Code::ocsp_revoked)
    services.events.raise(event_about(us, renewed.error()));
  if (!renewed || !*renewed) return;
  const auto response =
      identity.ocsp_response_for(identity.certificate(), services.clock.calendar_seconds());
  services.events.raise(event_about(
      us, Error(Code::ocsp_response_renewed,
                {.document = identity.ocsp_response_path(),
                 .field = "nextUpdate",
                 .found = response ? to_string(response->good.until()) : std::string("passed")})));
}

Error renewed_event(const OwnIdentity& identity, const pki::ValidChain& chain) {
  return Error(Code::identity_renewed, {.document = identity.identity_path(),
                                        .field = "notAfter",
                                        .found = to_string(chain.not_after()),
                                        .note = "serial number " + chain.certificate().serial()});
}

}  // namespace

void poll_renewal_list(const OwnIdentity& identity, const PluginServices& services) {
  const auto us = our_name(identity.guid());
  const auto taken = identity.listed().poll(services.clock, *identity.peer_trust());
  if (!taken) services.events.raise(event_about(us, taken.error()));
  if (taken && *taken) services.events.raise(event_about(us, **taken));
}

void renew_identities(IdentityTable& table, spi::IdentityHandle which, TrustStores& stores,
                      const PluginServices& services) {
  for (const auto& local : table.locals(which)) {
    auto& identity = *local.identity;
    // The CAs come first, because a new CA may have issued a renewed certificate. Our own must be
    // in the folder of trusted ones already.
    renew_trusted_folder(identity, stores, services);
    const auto taken = renew_authorities(identity, stores, services);
    const bool is_renewed = renew_certificate(identity, services) || taken.identity;
    poll_renewal_list(identity, services);
    renew_ocsp_response(identity, services);
    if (!is_renewed && !taken.authorities) continue;
    const auto chain = identity.verify(services.clock.calendar_seconds());
    if (!chain) continue;  // it has just ended, and `poll` reports that
    table.set_renewed(local.handle, *chain);
    if (is_renewed)
      services.events.raise(
          event_about(our_name(identity.guid()), renewed_event(identity, *chain)));
  }
}

void note_documents(const IdentityTable& table, spi::IdentityHandle which,
                    const PluginServices& services) {
  if (services.documents == nullptr) return;
  for (const auto& local : table.locals(which)) {
    const auto& identity = *local.identity;
    services.documents->note_participant(local.handle.value, identity.guid().to_string(),
                                         identity.certificate().subject());
    services.documents->note(local.handle.value, identity.documents(),
                             services.clock.calendar_seconds());
  }
}

void forget_documents(spi::IdentityHandle local, const PluginServices& services) {
  constexpr std::array kOurs = {DocumentKind::identity_certificate, DocumentKind::identity_ca,
                                DocumentKind::revocation_list, DocumentKind::renewal_list,
                                DocumentKind::ocsp_response};
  if (services.documents != nullptr) services.documents->forget(local.value, kOurs);
}

}  // namespace ddssec::authentication
