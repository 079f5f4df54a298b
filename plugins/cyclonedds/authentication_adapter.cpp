#include "plugins/cyclonedds/authentication_adapter.hpp"

#include <algorithm>
#include <atomic>
#include <dlfcn.h>

#include "plugins/cyclonedds/datagrams.hpp"
#include "plugins/cyclonedds/own_domain_tag.hpp"
#include "plugins/cyclonedds/plugins_in_use.hpp"
#include "plugins/cyclonedds/process_questions.hpp"
#include "plugins/cyclonedds/token_translation.hpp"
#include "plugins/cyclonedds/value_translation.hpp"
#include "plugins/spi/clock_step_grace.hpp"
#include "plugins/spi/flag_property.hpp"
#include "plugins/spi/process_properties.hpp"
#include "plugins/spi/property_names.hpp"
#include "plugins/spi/session_facts.hpp"

namespace ddssec::cyclonedds {
namespace {

using Adapter = AuthenticationAdapter;
using Instance = dds_security_authentication;
using CToken = DDS_Security_DataHolder;
using CResult = DDS_Security_ValidationResult_t;
using CIdentity = DDS_Security_IdentityHandle;
using CHandshake = DDS_Security_HandshakeHandle;

spi::IdentityHandle identity(CIdentity handle) { return {handle}; }
spi::HandshakeHandle handshake(CHandshake handle) { return {handle}; }

CResult to_c(spi::ValidationResult result) {
  switch (result) {
    case spi::ValidationResult::ok:
      return DDS_SECURITY_VALIDATION_OK;
    case spi::ValidationResult::pending_handshake_request:
      return DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_REQUEST;
    case spi::ValidationResult::pending_handshake_message:
      return DDS_SECURITY_VALIDATION_PENDING_HANDSHAKE_MESSAGE;
    case spi::ValidationResult::ok_final_message:
      return DDS_SECURITY_VALIDATION_OK_FINAL_MESSAGE;
  }
  return DDS_SECURITY_VALIDATION_FAILED;
}

// Calls `f(adapter) -> Result<CResult>`; any failure is DDS_SECURITY_VALIDATION_FAILED.
template <class F>
CResult validate(Instance* instance, Exception* ex, F&& f) noexcept {
  CResult result = DDS_SECURITY_VALIDATION_FAILED;
  const bool done = ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(result, f(adapter));
    return {};
  });
  return done ? result : DDS_SECURITY_VALIDATION_FAILED;
}

// Copies a token for the host. The copy is nil if there is no token.
Status copy_message(const std::optional<spi::Token>& token, CToken& out) {
  out = {};
  return token ? copy_token(*token, out) : Status{};
}

// Warns once per process. The host has created its sockets before it creates a participant.
void warn_of_transport_once(Host& host) {
  static std::atomic_flag asked;
  if (asked.test_and_set()) return;
  if (const auto warning = transport_warning(has_bound_udp())) host.notice(*warning);
}

CResult validate_local_identity(Instance* instance, CIdentity* handle,
                                DDS_Security_GUID_t* adjusted_guid,
                                const DDS_Security_DomainId domain_id, const DDS_Security_Qos* qos,
                                const DDS_Security_GUID_t* candidate_guid, Exception* ex) {
  return validate(instance, ex, [&](Adapter& adapter) -> Result<CResult> {
    DDSSEC_RETURN_IF_ERROR(require(handle, adjusted_guid, qos, candidate_guid));
    *handle = DDS_SECURITY_HANDLE_NIL;
    report_plugins_in_use(adapter.host(), PluginKind::authentication);
    warn_of_transport_once(adapter.host());
    DDSSEC_ASSIGN_OR_RETURN(auto property_list, properties_from(qos));
    DDSSEC_ASSIGN_OR_RETURN(const auto properties,
                            spi::with_process_properties(std::move(property_list)));
    DDSSEC_ASSIGN_OR_RETURN(const auto grace, spi::clock_step_grace(properties));
    adapter.host().calendar().set_grace(grace);
    DDSSEC_ASSIGN_OR_RETURN(const auto local,
                            adapter.plugin().validate_local_identity(domain_id, properties,
                                                                     guid_from(*candidate_guid)));
    adapter.lost_sessions().add_local(local.handle, local.adjusted_guid.prefix);
    adapter.dispose_announcements().add_local(local.handle, local.adjusted_guid.prefix);
    *handle = local.handle.value;
    *adjusted_guid = cyclonedds::to_c(local.adjusted_guid);
    return DDS_SECURITY_VALIDATION_OK;
  });
}

DDS_Security_boolean get_identity_token(Instance* instance, CToken* token, const CIdentity handle,
                                        Exception* ex) {
  return ask_token<Adapter>(instance, token, ex, [&](Adapter& adapter) {
    return adapter.plugin().identity_token(identity(handle), ciphers_of_process());
  });
}

DDS_Security_boolean get_identity_status_token(Instance* instance, CToken* token,
                                               const CIdentity handle, Exception* ex) {
  return ask_token<Adapter>(instance, token, ex, [&](Adapter& adapter) {
    return adapter.plugin().identity_status_token(identity(handle));
  });
}

DDS_Security_boolean set_permissions_credential_and_token(Instance* instance,
                                                          const CIdentity handle,
                                                          const CToken* credential,
                                                          const CToken* permissions_token,
                                                          Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(const auto credential_copy, token_from(credential));
    DDSSEC_ASSIGN_OR_RETURN(const auto token_copy, token_from(permissions_token));
    return adapter.plugin().set_permissions_credential_and_token(identity(handle), credential_copy,
                                                                 token_copy);
  });
}

// True if the refusal is final for this GUID, whatever is announced under it.
bool is_final(const Error& refusal) {
  return refusal.code() == Code::remote_guid_is_local || refusal.code() == Code::guid_not_adjusted;
}

struct DiscoveredPeer {
  Guid guid;
  HandshakeWatch::CoreTimerState timer;
};

// Handles a remote participant that was not admitted, without an error for the host. An attacker
// can announce something unreadable in a peer's name, and a full table or an outdated list is
// temporary. An error would end the core's handshake for as long as the peer is present. So the
// core asks again until the watch makes it discover the peer again. If governance admits
// unauthenticated participants, the core treats the peer as one.
Result<CResult> not_admitted(Adapter& adapter, CIdentity local, const DiscoveredPeer& discovered,
                             Error refusal, CIdentity& remote_handle) {
  if (is_final(refusal) || admits_unauthenticated(identity(local)) ||
      adapter.remotes().has_ended(identity(local)))
    return std::unexpected(std::move(refusal));
  const auto of_host = adapter.remotes().note_refused(discovered.guid);
  adapter.watch().note_not_admitted({identity(local), of_host}, discovered.guid, discovered.timer);
  remote_handle = of_host.value;
  return DDS_SECURITY_VALIDATION_PENDING_RETRY;
}

// If governance admits unauthenticated participants, the host treats the peer as one of them after
// an error, for all its participants.
Status may_begin(Adapter& adapter, spi::IdentityHandle local, const Guid& peer) {
  if (!admits_unauthenticated(local) || !adapter.watch().was_unanswered(peer)) return {};
  return fail(Code::handshake_begun_again,
              {.document = "the handshake with a discovered participant",
               .expected = "that it ends",
               .found = "none that ended",
               .note = "governance admits unauthenticated participants; it counts as one"});
}

CResult validate_remote_identity(Instance* instance, CIdentity* remote_handle,
                                 CToken* local_auth_request, const CToken* /*remote_auth_request*/,
                                 const CIdentity local_handle, const CToken* remote_token,
                                 const DDS_Security_GUID_t* remote_guid, Exception* ex) {
  bool is_call_of_core = false;
  const auto result = validate(instance, ex, [&](Adapter& adapter) -> Result<CResult> {
    // The core calls strlen on this class id later, even after a refusal or without a token to
    // send. When it asks again, it passes the string from the former call.
    DDSSEC_RETURN_IF_ERROR(require(local_auth_request));
    if (local_auth_request->class_id == nullptr)
      DDSSEC_RETURN_IF_ERROR(copy_token(spi::Token{}, *local_auth_request));
    DDSSEC_RETURN_IF_ERROR(require(remote_handle, remote_token, remote_guid));
    *remote_handle = DDS_SECURITY_HANDLE_NIL;
    const DiscoveredPeer discovered{
        guid_from(*remote_guid),
        adapter.stop_core_timer({instance, local_auth_request, remote_guid})};
    is_call_of_core = discovered.timer == HandshakeWatch::CoreTimerState::stopped;
    DDSSEC_RETURN_IF_ERROR(may_begin(adapter, identity(local_handle), discovered.guid));
    // The peer's own auth_request is not used, because it can be forged. The plugin would compare a
    // forged challenge with the honest peer's messages until the peer's lease ends. The signatures
    // of the handshake are sufficient proof. The core asks once, so the local auth_request is
    // always sent.
    const auto token = token_from(remote_token);
    if (!token) {
      adapter.host().refused(token.error(), info(token.error().code()).severity);
      return not_admitted(adapter, local_handle, discovered, token.error(), *remote_handle);
    }
    const auto admitted = adapter.plugin().validate_remote_identity(
        identity(local_handle), std::nullopt, *token, discovered.guid);
    if (!admitted)
      return not_admitted(adapter, local_handle, discovered, admitted.error(), *remote_handle);
    const auto& remote = *admitted;
    const auto of_host =
        adapter.remotes().note(identity(local_handle), discovered.guid, remote.handle);
    if (remote.local_auth_request) {
      CToken sent{};
      DDSSEC_RETURN_IF_ERROR(copy_token(*remote.local_auth_request, sent));
      std::swap(*local_auth_request, sent);
      free_token(sent);
    }
    adapter.watch().note_discovered({identity(local_handle), of_host}, discovered.guid,
                                    discovered.timer);
    *remote_handle = of_host.value;
    return to_c(remote.result);
  });
  // Cyclone's core frees its copy of the token only after a success. Strangers would fill the
  // memory with tokens. The core never uses a refused token again, and may free an empty one.
  if (is_call_of_core && result == DDS_SECURITY_VALIDATION_FAILED)
    free_token(const_cast<CToken&>(*remote_token));
  return result;
}

// Does nothing for a local participant that is cut off, because the host drops a peer for all its
// participants.
void note_refused(Adapter& adapter, spi::IdentityHandle local, spi::IdentityHandle remote) {
  if (!adapter.remotes().has_ended(local)) adapter.watch().note_refused(remote);
}
void note_refused(Adapter& adapter, spi::HandshakeHandle handshake) {
  const auto pair = adapter.secrets().pair_of(handshake);
  const auto& remotes = adapter.remotes();
  if (pair && (remotes.has_ended(pair->first) || remotes.has_ended(pair->second))) return;
  adapter.watch().note_refused(handshake);
}

struct HandshakePair {
  spi::IdentityHandle local, remote;
};

// Returns the core's data about the local participant, and keeps it for announcements. If it has a
// domain tag, no handshake begins, and none is to begin again.
Result<BytesView> own_data(Adapter& adapter, HandshakePair pair,
                           const DDS_Security_OctetSeq* data) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, octets_from(data));
  if (auto has_none = check_no_domain_tag(octets); !has_none) {
    adapter.watch().forget(pair.remote);
    return std::unexpected(std::move(has_none.error()));
  }
  for (const auto& local : adapter.dispose_announcements().locals())
    if (local.handle == pair.local)
      adapter.own_announcements().note_data(local.handle, local.prefix, octets);
  return octets;
}

CResult begin_handshake_request(Instance* instance, CHandshake* handle, CToken* message,
                                const CIdentity initiator, const CIdentity replier,
                                const DDS_Security_OctetSeq* participant_data, Exception* ex) {
  return validate(instance, ex, [&](Adapter& adapter) -> Result<CResult> {
    DDSSEC_RETURN_IF_ERROR(require(handle, message));
    *handle = DDS_SECURITY_HANDLE_NIL;
    *message = {};
    DDSSEC_ASSIGN_OR_RETURN(
        const auto data,
        own_data(adapter, {identity(initiator), identity(replier)}, participant_data));
    const auto remote = adapter.remotes().pair(identity(initiator), identity(replier));
    auto begun = adapter.plugin().begin_handshake_request(identity(initiator), remote, data);
    // The core gives up this peer. No attacker can cause that, so there is nothing to begin again.
    if (!begun) adapter.watch().forget(identity(replier));
    DDSSEC_ASSIGN_OR_RETURN(const auto step, std::move(begun));
    adapter.secrets().note(step.handle, identity(initiator), identity(replier));
    adapter.watch().note_progress({identity(initiator), identity(replier)}, step.handle);
    DDSSEC_RETURN_IF_ERROR(copy_message(step.message, *message));
    *handle = step.handle.value;
    return to_c(step.result);
  });
}

CResult begin_handshake_reply(Instance* instance, CHandshake* handle, CToken* message_out,
                              const CToken* message_in, const CIdentity initiator,
                              const CIdentity replier,
                              const DDS_Security_OctetSeq* participant_data, Exception* ex) {
  return validate(instance, ex, [&](Adapter& adapter) -> Result<CResult> {
    DDSSEC_RETURN_IF_ERROR(require(handle, message_out, message_in));
    *handle = DDS_SECURITY_HANDLE_NIL;
    *message_out = {};
    DDSSEC_ASSIGN_OR_RETURN(const auto request, token_from(message_in));
    DDSSEC_ASSIGN_OR_RETURN(
        const auto data,
        own_data(adapter, {identity(replier), identity(initiator)}, participant_data));
    const auto remote = adapter.remotes().pair(identity(replier), identity(initiator));
    auto begun = adapter.plugin().begin_handshake_reply(request, remote, identity(replier), data);
    if (!begun) note_refused(adapter, identity(replier), identity(initiator));
    DDSSEC_ASSIGN_OR_RETURN(const auto step, std::move(begun));
    adapter.secrets().note(step.handle, identity(initiator), identity(replier));
    adapter.watch().note_progress({identity(replier), identity(initiator)}, step.handle);
    DDSSEC_RETURN_IF_ERROR(copy_message(step.message, *message_out));
    *handle = step.handle.value;
    return to_c(step.result);
  });
}

CResult process_handshake(Instance* instance, CToken* message_out, const CToken* message_in,
                          const CHandshake handle, Exception* ex) {
  return validate(instance, ex, [&](Adapter& adapter) -> Result<CResult> {
    DDSSEC_RETURN_IF_ERROR(require(message_out, message_in));
    *message_out = {};
    DDSSEC_ASSIGN_OR_RETURN(const auto message, token_from(message_in));
    auto processed = adapter.plugin().process_handshake(handshake(handle), message);
    if (!processed) note_refused(adapter, handshake(handle));
    DDSSEC_ASSIGN_OR_RETURN(const auto step, std::move(processed));
    DDSSEC_RETURN_IF_ERROR(copy_message(step.message, *message_out));
    if (step.result == spi::ValidationResult::ok ||
        step.result == spi::ValidationResult::ok_final_message)
      adapter.watch().note_finished(handshake(handle));
    return to_c(step.result);
  });
}

// Returns what the handshake presented of the permissions; empty if that is unknown.
LostSessions::Presented presented_in(Adapter& adapter, spi::HandshakeHandle handshake) {
  const auto credential = adapter.plugin().authenticated_peer_credential_token(handshake);
  return credential ? spi::session_facts_in(*credential).presented_permissions : std::nullopt;
}

// Remembers the session, so that a reset can be sent if the host drops the peer while the peer
// keeps the session. Only ddssec peers understand a reset, and they announce ChaCha20-Poly1305. For
// other peers the watch waits.
void note_session(Adapter& adapter, spi::HandshakeHandle handshake,
                  const spi::SharedSecret& secret) {
  const auto pair = adapter.secrets().pair_of(handshake);
  if (!pair) return;
  auto [local, remote] = *pair;
  auto guid = adapter.remotes().guid(remote);
  if (!guid) {
    std::swap(local, remote);
    guid = adapter.remotes().guid(remote);
  }
  if (!guid) return;
  if ((secret.peer_ciphers & spi::kChaCha20Poly1305Bit) != 0)
    adapter.lost_sessions().established(local, *guid, secret, presented_in(adapter, handshake));
  else
    adapter.watch().note_session_kept(handshake);
}

DDS_Security_SharedSecretHandle get_shared_secret(Instance* instance, const CHandshake handle,
                                                  Exception* ex) {
  DDS_Security_SharedSecretHandle secret_handle = DDS_SECURITY_HANDLE_NIL;
  const bool done = ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(const auto secret, adapter.plugin().shared_secret(handshake(handle)));
    DDSSEC_ASSIGN_OR_RETURN(secret_handle,
                            adapter.secrets().pointer_for(handshake(handle), *secret));
    note_session(adapter, handshake(handle), *secret);
    return {};
  });
  return done ? secret_handle : DDS_SECURITY_HANDLE_NIL;
}

DDS_Security_boolean get_authenticated_peer_credential_token(Instance* instance, CToken* token,
                                                             const CHandshake handle,
                                                             Exception* ex) {
  return ask_token<Adapter>(instance, token, ex, [&](Adapter& adapter) -> Result<spi::Token> {
    DDSSEC_ASSIGN_OR_RETURN(
        auto credential, adapter.plugin().authenticated_peer_credential_token(handshake(handle)));
    return with_text_properties(std::move(credential));
  });
}

DDS_Security_boolean return_handshake_handle(Instance* instance, const CHandshake handle,
                                             Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    if (handle == DDS_SECURITY_HANDLE_NIL) return {};
    adapter.watch().forget(handshake(handle));
    return adapter.plugin().return_handshake_handle(handshake(handle));
  });
}

DDS_Security_boolean return_identity_handle(Instance* instance, const CIdentity handle,
                                            Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    if (handle == DDS_SECURITY_HANDLE_NIL) return {};
    if (const auto guid = adapter.remotes().guid(identity(handle))) {
      adapter.lost_sessions().lost(*guid);
      return_permissions_of(identity(handle));
    } else {
      for (const auto& reset : adapter.lost_sessions().remove_local(identity(handle)))
        send_datagram(reset.message, reset.to);
      adapter.dispose_announcements().remove_local(identity(handle));
      adapter.own_announcements().remove_local(identity(handle));
    }
    adapter.secrets().drop(identity(handle));
    adapter.watch().forget(identity(handle));
    Status status;
    for (const auto one : adapter.remotes().take(identity(handle)))
      if (auto returned = adapter.plugin().return_identity_handle(one); !returned)
        status = std::move(returned);
    return status;
  });
}

// The secret stays until its remote identity is returned, because cryptography may still read it.
DDS_Security_boolean return_sharedsecret_handle(Instance* instance,
                                                const DDS_Security_SharedSecretHandle,
                                                Exception* ex) {
  return ask<Adapter>(instance, ex, [](Adapter&) -> Status { return {}; });
}

constexpr dds_security_authentication kTable = {
    .gv = nullptr,
    .validate_local_identity = validate_local_identity,
    .get_identity_token = get_identity_token,
    .get_identity_status_token = get_identity_status_token,
    .set_permissions_credential_and_token = set_permissions_credential_and_token,
    .validate_remote_identity = validate_remote_identity,
    .begin_handshake_request = begin_handshake_request,
    .begin_handshake_reply = begin_handshake_reply,
    .process_handshake = process_handshake,
    .get_shared_secret = get_shared_secret,
    .get_authenticated_peer_credential_token = get_authenticated_peer_credential_token,
    .set_listener = set_listener<Adapter>,
    .return_identity_token = return_token<Adapter>,
    .return_identity_status_token = return_token<Adapter>,
    .return_authenticated_peer_credential_token = return_token<Adapter>,
    .return_handshake_handle = return_handshake_handle,
    .return_identity_handle = return_identity_handle,
    .return_sharedsecret_handle = return_sharedsecret_handle,
};

}  // namespace

AuthenticationAdapter::AuthenticationAdapter(std::unique_ptr<Host> host,
                                             const MakePlugin<spi::Authentication>& make,
                                             ddsi_domaingv* domain, Pace pace)
    : dds_security_authentication(kTable),
      host_(std::move(host)),
      plugin_(make(host_->services_with_record(true))),
      core_timer_(CoreTimer::of_host(host_->code())),
      watch_(host_->clock()),
      lost_sessions_(host_->clock()),
      patience_(pace.patience),
      kept_handshake_(pace.kept_handshake),
      timer_(host_->clock(), pace.step) {
  gv = domain;
}

void AuthenticationAdapter::present_renewed_permissions() {
  const auto locals = dispose_announcements_.locals();
  const auto is_gone = [&](const auto& entry) {
    return std::ranges::find(locals, entry.first, &DisposeAnnouncements::Local::handle) ==
           locals.end();
  };
  std::erase_if(renewals_, is_gone);
  std::erase_if(presented_, is_gone);
  std::erase_if(rights_changes_, is_gone);
  for (const auto& local : locals) {
    // The changes are read first: the text that is read after them is no older, so no new session
    // begins with the former rights.
    const auto changes = rights_changed(local.handle);
    auto times = renewals_[local.handle];
    auto text = renewed_permissions(local.handle, times);
    if (!text) {
      note_changed_rights(local.handle, changes);
      continue;
    }
    const auto digest = sha256(as_bytes(*text));
    const spi::Token credential{.class_id = std::string(spi::class_id::kPermissionsCredential),
                                .properties = {{"dds.perm.cert", *std::move(text), false}}};
    // A refusal has its own event; the same document is not tried again.
    presented_.erase(local.handle);
    if (plugin_->set_permissions_credential_and_token(local.handle, credential, {}))
      presented_[local.handle] = digest;
    renewals_[local.handle] = times;
    note_changed_rights(local.handle, changes);
  }
}

bool AuthenticationAdapter::has_others(spi::IdentityHandle local) const {
  return std::ranges::any_of(dispose_announcements_.locals(), [&](const auto& other) {
    return other.handle != local && !remotes_.has_ended(other.handle) &&
           !holds(GovernanceFact::cut_off, other.handle);
  });
}

void AuthenticationAdapter::listen(const dds_security_authentication_listener* listener) {
  if (listener == nullptr || listener->on_revoke_identity == nullptr) return timer_.stop();
  const auto revoke = listener->on_revoke_identity;
  timer_.start({.revoke_ended =
                    [this, revoke](const std::stop_token& stop) {
                      report_clock_steps(*host_, PluginKind::authentication);
                      present_renewed_permissions();
                      const auto ended = remotes_.to_revoke(plugin_->poll());
                      for (const auto local : ended.locals) {
                        cut_off_access_control(local);
                        cut_off_cryptography(local);
                        watch_.forget(local);
                        if (has_others(local)) revoke(this, local.value);
                      }
                      const auto end = [&](std::int64_t remote) { revoke(this, remote); };
                      for (const auto remote : ended.remotes)
                        if (!stop.stop_requested()) cut_off_peer(remote, end);
                      revoke_stuck(stop, end);
                      follow_resets(stop, end, revoke_noted(stop, end));
                      send_announcements();
                      revoke_stranded(stop, end);
                      send_resets();
                      report_ended_by_peer();
                    },
                .next_expiry = [this] { return plugin_->next_expiry(); }});
}

}  // namespace ddssec::cyclonedds
