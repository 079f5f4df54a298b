#include "plugins/authentication/authentication.hpp"

#include <algorithm>
#include <set>

#include "plugins/authentication/adjusted_guid.hpp"
#include "plugins/authentication/auth_request.hpp"
#include "plugins/authentication/identity_token.hpp"
#include "plugins/authentication/listed_identities.hpp"
#include "plugins/authentication/pki_dh.hpp"
#include "plugins/authentication/renewal.hpp"
#include "plugins/authentication/revocations.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::authentication {
namespace {

constexpr auto kStartAgain =
    "renew it (ddssec identity renew FOLDER --ca CA) and start this participant again";

// A peer that has renewed its certificate comes back at once, so its end is not reported as an
// error.
Event event_of_end(const IdentityTable::EndedIdentity& ended, WallTime now) {
  const bool is_own = ended.peer.subject.empty();
  auto out = event_about(
      ended.peer,
      Error(ended.own_certificate_ended ? Code::session_outlived_documents : Code::identity_ended,
            {.document = ended.whose,
             .field = "notAfter",
             .expected = "a time before " + to_string(ended.end),
             .found = to_string(now),
             .note = ended.note,
             .hint = is_own ? kStartAgain : ""}));
  if (!is_own) out.severity = std::min(out.severity, Severity::warning);
  return out;
}

}  // namespace

Result<PkiDh::LocalIdentity> PkiDh::validate_local_identity(DomainId,
                                                            const spi::PropertyList& properties,
                                                            const Guid& candidate_guid) {
  auto loaded = load_local(properties, candidate_guid);
  if (!loaded) services_.events.raise(Event::of_returned(loaded.error()));
  return loaded;
}

Result<PkiDh::LocalIdentity> PkiDh::load_local(const spi::PropertyList& properties,
                                               const Guid& candidate) {
  const WallTime now = services_.clock.calendar_seconds();
  DDSSEC_ASSIGN_OR_RETURN(auto files, IdentityFiles::load(properties, stores_, now));
  const auto no_list = files.revocation_lists.absence();
  auto identity = std::make_shared<OwnIdentity>(std::move(files), candidate);
  DDSSEC_ASSIGN_OR_RETURN(const auto chain, identity->verify(now));
  DDSSEC_ASSIGN_OR_RETURN(const auto handle, table_.add_local(identity, chain));
  if (no_list) services_.events.raise(event_about(our_name(identity->guid()), *no_list));
  note_documents_in_use(handle);
  return LocalIdentity{handle, identity->guid()};
}

Result<Token> PkiDh::identity_token(IdentityHandle local, spi::CipherMask ciphers) {
  DDSSEC_ASSIGN_OR_RETURN(const auto identity, reported(table_.local(local)));
  return identity->identity_token(ciphers);
}

Result<Token> PkiDh::identity_status_token(IdentityHandle local) {
  DDSSEC_RETURN_IF_ERROR(reported(table_.local(local)));
  return Token{std::string(spi::class_id::kIdentity)};
}

Status PkiDh::set_permissions_credential_and_token(IdentityHandle local, const Token& credential,
                                                   const Token&) {
  DDSSEC_ASSIGN_OR_RETURN(const auto identity, reported(table_.local(local)));
  return reported(identity->set_permissions(credential));
}

Result<PkiDh::RemoteIdentity> PkiDh::validate_remote_identity(
    IdentityHandle local, const std::optional<Token>& remote_auth_request,
    const Token& remote_identity_token, const Guid& remote_guid) {
  auto result = admit(local, remote_auth_request, remote_identity_token, remote_guid);
  return result ? result : reported(std::move(result), PeerName{{}, remote_guid.to_string()});
}

Result<PkiDh::RemoteIdentity> PkiDh::admit(IdentityHandle local,
                                           const std::optional<Token>& auth_request,
                                           const Token& identity_token, const Guid& guid) {
  DDSSEC_ASSIGN_OR_RETURN(const auto identity, table_.local(local));
  DDSSEC_ASSIGN_OR_RETURN(auto claim, read_identity_token(identity_token));
  if (guid == identity->guid()) return fail(Code::remote_guid_is_local);
  if (!is_adjusted(guid)) return fail(Code::guid_not_adjusted, {.found = guid.to_string()});
  std::optional<spi::Challenge> announced;
  if (auth_request) {
    DDSSEC_ASSIGN_OR_RETURN(announced, read_auth_request(*auth_request));
  }
  DDSSEC_RETURN_IF_ERROR(identity->verify(services_.clock.calendar_seconds()));
  const auto kept = kept_requests_.challenge(local, guid, services_.clock.monotonic());
  auto own_challenge = kept.value_or(spi::Challenge{});
  if (!kept) DDSSEC_RETURN_IF_ERROR(services_.random.fill(own_challenge));

  DDSSEC_ASSIGN_OR_RETURN(
      const auto pair, table_.admit_remote(local, {guid, std::move(claim.subject)}, own_challenge));
  const std::scoped_lock lock(pair->mutex);
  if (kept && pair->own_challenge == *kept) restore_kept_request(pair);
  if (announced) pair->announced_challenge = announced;
  RemoteIdentity result{pair->remote_handle, ValidationResult::pending_handshake_message,
                        std::nullopt};
  if (initiates(identity->guid(), guid))
    result.result = ValidationResult::pending_handshake_request;
  if (!announced) result.local_auth_request = write_auth_request(pair->own_challenge);
  return result;
}

Status PkiDh::return_identity_handle(IdentityHandle identity) {
  const auto pair = table_.pair_of(identity);
  if (!table_.remove(identity)) return fail(Code::unknown_identity);
  if (pair)
    kept_requests_.keep(*pair, services_.clock.monotonic());
  else
    kept_requests_.forget(identity);
  const std::scoped_lock lock(noting_mutex_);
  forget_documents(identity, services_);
  return {};
}

void PkiDh::note_documents_in_use(IdentityHandle local) noexcept {
  try {
    const std::scoped_lock lock(noting_mutex_);
    note_documents(table_, local, services_);
  } catch (...) {
    // If memory is short, the next look notes them.
  }
}

// Notes the end for the record that a person reads. The record has no peers.
void PkiDh::note_end(IdentityHandle identity, const Error& why, WallTime now) {
  if (services_.documents != nullptr) services_.documents->note_end(identity.value, why, now);
}

// True if the session did not end because of our own end, which has its own event.
bool PkiDh::has_outlived(const std::vector<IdentityTable::EndedIdentity>& all,
                         const IdentityTable::EndedIdentity& session) const {
  const auto pair = table_.pair_of(session.handle);
  return pair && table_.local(pair->local_handle) &&
         std::ranges::find(all, pair->local_handle, &IdentityTable::EndedIdentity::handle) ==
             all.end();
}

// Reads what the files of local identities contain now. Each identity looks at its files at its own
// interval. Before one of them ends, all look, for two reasons: identities with the same files end
// together, and a file that came before the end counts.
Revocations PkiDh::poll_files(IdentityHandle local) {
  renew_identities(table_, local, stores_, services_);
  auto revocations = find_revocations(table_, local, stores_, services_);
  const auto own = table_.locals(local);
  const auto is_own = [&](IdentityHandle handle) {
    return std::ranges::find(own, handle, &IdentityTable::OwnIdentityEntry::handle) != own.end();
  };
  const auto ended = table_.ended_by(services_.clock.calendar_seconds(), local);
  if (std::ranges::none_of(revocations.identities, is_own,
                           &IdentityTable::RevokedIdentity::handle) &&
      std::ranges::none_of(ended, is_own, &IdentityTable::EndedIdentity::handle))
    return revocations;
  for (const auto& one : own) one.identity->force_poll();
  renew_identities(table_, local, stores_, services_);
  return find_revocations(table_, local, stores_, services_);
}

std::vector<IdentityHandle> PkiDh::poll(IdentityHandle local) {
  drop_credentials_given_out();
  const auto revocations = poll_files(local);
  note_documents_in_use(local);
  const auto now = services_.clock.calendar_seconds();
  auto all = table_.ended_by(now, local);
  follow_renewal_lists(table_, all, services_);
  // If there is not enough memory to report them, none is marked: the next call finds them again.
  std::vector<IdentityHandle> handles;
  std::set<IdentityHandle> told;
  const auto tell_one = [&](IdentityHandle handle) {
    if (told.insert(handle).second) handles.push_back(handle);
  };
  const auto tell = [&](IdentityHandle handle) {
    tell_one(handle);
    std::ranges::for_each(table_.peers_of(handle), tell_one);
  };
  std::vector<Event> events;
  for (const auto& revoked : revocations.identities) {
    tell(revoked.handle);
    events.push_back(event_about(revoked.peer, revoked.reason));
    note_end(revoked.handle, revoked.reason, now);
  }
  for (const auto& ended : all) {
    tell(ended.handle);
    if (ended.own_certificate_ended && !has_outlived(all, ended)) continue;
    events.push_back(event_of_end(ended, now));
    note_end(ended.handle, events.back().error, now);
  }
  for (const auto& own : table_.locals(local))
    for (const auto& error : own.identity->ends_soon(now))
      events.push_back(event_about(our_name(own.identity->guid()), error));
  // The steps that need no memory come last, so that every identity that is marked was reported.
  for (const auto& event : events) services_.events.raise(event);
  table_.mark_revoked(revocations.identities);
  table_.mark_ended(all);
  for (const auto& judgement : revocations.judgements) judgement.note_applied();
  return handles;
}

std::unique_ptr<spi::Authentication> make_authentication(const PluginServices& services,
                                                         AuthenticationOptions options) {
  return std::make_unique<PkiDh>(services, options);
}

}  // namespace ddssec::authentication
