#include "plugins/authentication/authentication.hpp"

#include <algorithm>
#include <functional>
#include <mutex>
#include <set>

#include "plugins/authentication/adjusted_guid.hpp"
#include "plugins/authentication/auth_request.hpp"
#include "plugins/authentication/identity_table.hpp"
#include "plugins/authentication/identity_token.hpp"
#include "plugins/authentication/kept_requests.hpp"
#include "plugins/authentication/participant_data.hpp"
#include "plugins/authentication/renewal.hpp"
#include "plugins/authentication/revocation.hpp"
#include "plugins/spi/property_names.hpp"
#include "plugins/spi/session_facts.hpp"

namespace ddssec::authentication {
namespace {

using spi::HandshakeHandle;
using spi::IdentityHandle;
using spi::Token;
using spi::ValidationResult;

/// DDS-Security 1.2, clause 10.3.3: the lower GUID, octet by octet, begins.
bool initiates(const Guid& local, const Guid& remote) { return local < remote; }

Status check_role(bool is_right, std::string_view call) {
  if (is_right) return {};
  return fail(Code::handshake_role_wrong, {.field = std::string(call)});
}

/// Finished handshakes of one pair that stay open to questions.
constexpr std::size_t kMostFinishedPerPair = 4;

bool is_pending(const PairHandshake& handshake) {
  return !std::holds_alternative<Established>(handshake.state);
}

class PkiDh final : public spi::Authentication {
 public:
  PkiDh(const Environment& environment, const Options& options)
      : environment_(environment),
        stores_(options.crl_policy),
        table_(options.most_local_identities,
               {.most_claimed = options.most_remote_identities,
                .most_authenticated = options.most_remote_identities,
                .most_of_a_subject = options.most_identities_of_a_subject}) {}

  Result<LocalIdentity> validate_local_identity(DomainId domain_id,
                                                const spi::PropertyList& properties,
                                                const Guid& candidate_guid) override;
  Result<Token> identity_token(IdentityHandle local, spi::CipherMask ciphers) override;
  Result<Token> identity_status_token(IdentityHandle local) override;
  Status set_permissions_credential_and_token(IdentityHandle local, const Token& credential,
                                              const Token& permissions_token) override;
  Result<RemoteIdentity> validate_remote_identity(IdentityHandle local,
                                                  const std::optional<Token>& remote_auth_request,
                                                  const Token& remote_identity_token,
                                                  const Guid& remote_guid) override;
  Result<HandshakeStep> begin_handshake_request(IdentityHandle initiator, IdentityHandle replier,
                                                BytesView participant_data) override;
  Result<HandshakeStep> begin_handshake_reply(const Token& request, IdentityHandle initiator,
                                              IdentityHandle replier,
                                              BytesView participant_data) override;
  Result<HandshakeStep> process_handshake(HandshakeHandle handshake, const Token& message) override;
  Result<std::shared_ptr<const spi::SharedSecret>> shared_secret(
      HandshakeHandle handshake) override;
  Result<Token> authenticated_peer_credential_token(HandshakeHandle handshake) override;
  std::string authenticated_subject(HandshakeHandle handshake) override;
  Status return_handshake_handle(HandshakeHandle handshake) override;
  Status return_identity_handle(IdentityHandle identity) override;
  std::optional<WallTime> next_expiry() override { return table_.next_end(); }
  std::vector<IdentityHandle> expire(IdentityHandle local) override;

 private:
  template <class T>
  Result<T> reported(Result<T> result, const PeerName& peer = {}) const {
    if (!result) environment_.events.raise(event_about(peer, result.error()));
    return result;
  }
  /// Of a message of a handshake: a stranger can send one in the name of a peer that authenticated.
  template <class T>
  Result<T> reported(Result<T> result, IdentityHandle remote) const {
    if (result) return result;
    auto name = table_.name_of(remote);
    name.proof = PeerProof::claimed;
    return reported(std::move(result), name);
  }

  void drop_credentials_given_out();
  bool has_outlived(const std::vector<IdentityTable::Ended>& all,
                    const IdentityTable::Ended& session) const;
  bool may_go_on(const Pair& pair, const PairHandshake& handshake,
                 const std::shared_ptr<const Presented>& own) const;
  Result<LocalIdentity> load_local(const spi::PropertyList& properties, const Guid& candidate);
  Result<RemoteIdentity> admit(IdentityHandle local, const std::optional<Token>& auth_request,
                               const Token& identity_token, const Guid& guid);
  Result<HandshakeStep> request(IdentityHandle local, IdentityHandle remote,
                                BytesView participant_data);
  Result<HandshakeStep> reply(const Token& request, IdentityHandle local, IdentityHandle remote,
                              BytesView participant_data);
  Result<HandshakeStep> step(HandshakeHandle handle, const Token& message);
  Result<HandshakeContext> context(const Pair& pair) const;
  Status note_authenticated(const Pair& pair, const Established& done);
  void take_up_request(const std::shared_ptr<Pair>& pair);
  Status check_room(const Pair& pair) const;
  void make_room(Pair& pair);
  HandshakeStep keep(const std::shared_ptr<Pair>& pair, HandshakeOutcome outcome,
                     BytesView participant_data, UnprovenOctets::Share unproven = {});
  Result<UnprovenOctets::Share> share_of(const Pair& pair, const Token& request,
                                         const HandshakeOutcome& outcome);
  /// `f(const Established&)` under the pair's lock.
  template <class F>
  auto established(HandshakeHandle handle, F&& f) const
      -> Result<std::invoke_result_t<F, const Established&>>;

  const Environment environment_;
  TrustStores stores_;
  UnprovenOctets unproven_;
  IdentityTable table_;
  KeptRequests kept_requests_{environment_.random};
  std::mutex given_out_mutex_;
  std::vector<HandshakeHandle> given_out_;  ///< whose credentials, since the last `expire`
};

// ---- identities

Result<PkiDh::LocalIdentity> PkiDh::validate_local_identity(DomainId,
                                                            const spi::PropertyList& properties,
                                                            const Guid& candidate_guid) {
  auto loaded = load_local(properties, candidate_guid);
  if (!loaded) environment_.events.raise(Event::of_returned(loaded.error()));
  return loaded;
}

Result<PkiDh::LocalIdentity> PkiDh::load_local(const spi::PropertyList& properties,
                                               const Guid& candidate) {
  const WallTime now = environment_.clock.now();
  DDSSEC_ASSIGN_OR_RETURN(auto files, IdentityFiles::load(properties, stores_, now));
  const auto no_list = files.revocation_lists.absence();
  auto identity = std::make_shared<authentication::LocalIdentity>(std::move(files), candidate);
  DDSSEC_ASSIGN_OR_RETURN(const auto chain, identity->verify(now));
  DDSSEC_ASSIGN_OR_RETURN(const auto handle, table_.add_local(identity, chain));
  if (no_list) environment_.events.raise(event_about(our_name(identity->guid()), *no_list));
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
  DDSSEC_RETURN_IF_ERROR(identity->verify(environment_.clock.now()));
  const auto kept = kept_requests_.challenge(local, guid, environment_.clock.monotonic());
  auto own_challenge = kept.value_or(spi::Challenge{});
  if (!kept) DDSSEC_RETURN_IF_ERROR(environment_.random.fill(own_challenge));

  DDSSEC_ASSIGN_OR_RETURN(
      const auto pair,
      table_.admit_remote(local, {guid, identity_token, std::move(claim.subject)}, own_challenge));
  const std::scoped_lock lock(pair->mutex);
  if (kept && pair->own_challenge == *kept) take_up_request(pair);
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
    kept_requests_.keep(*pair, environment_.clock.monotonic());
  else
    kept_requests_.forget(identity);
  return {};
}

/// True if our own end is not what ended the session: it would have its own event.
bool PkiDh::has_outlived(const std::vector<IdentityTable::Ended>& all,
                         const IdentityTable::Ended& session) const {
  const auto pair = table_.pair_of(session.handle);
  return pair && table_.local(pair->local_handle) &&
         std::ranges::find(all, pair->local_handle, &IdentityTable::Ended::handle) == all.end();
}

std::vector<IdentityHandle> PkiDh::expire(IdentityHandle local) {
  drop_credentials_given_out();
  renew_identities(table_, local, stores_, environment_);
  const auto now = environment_.clock.now();
  const auto revocations = find_revocations(table_, local, stores_, environment_);
  const auto all = table_.ended_by(now, local);
  // Without the memory to tell, none is marked: the next call finds them again.
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
  }
  for (const auto& ended : all) {
    tell(ended.handle);
    if (ended.with_ours && !has_outlived(all, ended)) continue;
    events.push_back(event_about(
        ended.peer, Error(ended.with_ours ? Code::session_outlived_documents : Code::identity_ended,
                          {.document = ended.whose,
                           .field = "notAfter",
                           .expected = "a time before " + to_string(ended.end),
                           .found = to_string(now)})));
  }
  for (const auto& own : table_.locals(local))
    for (const auto& error : own.identity->ends_soon(now))
      events.push_back(event_about(our_name(own.identity->guid()), error));
  // Last what needs no memory: marked identities are reported.
  for (const auto& event : events) environment_.events.raise(event);
  table_.mark_revoked(revocations.identities);
  table_.mark_ended(all);
  for (const auto& judgement : revocations.judgements) judgement.note_applied();
  return handles;
}

// ---- handshakes

Result<HandshakeContext> PkiDh::context(const Pair& pair) const {
  const WallTime now = environment_.clock.now();
  DDSSEC_RETURN_IF_ERROR(pair.local->verify(now));
  return HandshakeContext{*pair.local, pair.remote_guid, pair.own_challenge,
                          pair.announced_challenge, now};
}

/// The pair's lock is held.
void PkiDh::take_up_request(const std::shared_ptr<Pair>& pair) {
  auto [request, reply_keys] = kept_requests_.take(pair->local_handle, pair->remote_guid);
  pair->reply_keys = std::move(reply_keys);
  if (!request) return;
  pair->handshakes.reserve(pair->handshakes.size() + 1);
  request->handle = table_.add_handshake(pair);
  pair->handshakes.push_back(std::move(*request));
}

/// A handshake under way goes on with what it began with. If what we present was renewed since, it
/// has kPendingAge for that; then the same message begins another.
bool PkiDh::may_go_on(const Pair& pair, const PairHandshake& handshake,
                      const std::shared_ptr<const Presented>& own) const {
  return own == pair.local->presented() ||
         environment_.clock.monotonic() - handshake.since < kPendingAge;
}

/// Only one that waited long gives way to another.
Status PkiDh::check_room(const Pair& pair) const {
  const auto& all = pair.handshakes;
  const auto pending = std::ranges::count_if(all, is_pending);
  if (static_cast<std::size_t>(pending) < kMostPendingPerPair) return {};
  const auto oldest = std::ranges::find_if(all, is_pending);
  if (environment_.clock.monotonic() - oldest->since >= kPendingAge) return {};
  return fail(Code::too_many_handshakes,
              {.expected = "at most " + std::to_string(kMostPendingPerPair)});
}

void PkiDh::make_room(Pair& pair) {
  auto& all = pair.handshakes;
  const auto drop_first = [&](auto&& is_one) {
    const auto first = std::ranges::find_if(all, is_one);
    if (first == all.end()) return;
    table_.remove_handshake(first->handle);
    all.erase(first);
  };
  const auto pending = static_cast<std::size_t>(std::ranges::count_if(all, is_pending));
  if (pending >= kMostPendingPerPair) drop_first(is_pending);
  // Of finished ones the host keeps what it needs as shared pointers.
  if (all.size() - pending >= kMostFinishedPerPair) drop_first(std::not_fn(is_pending));
}

PkiDh::HandshakeStep PkiDh::keep(const std::shared_ptr<Pair>& pair, HandshakeOutcome outcome,
                                 BytesView participant_data, UnprovenOctets::Share unproven) {
  PairHandshake kept{{},
                     std::move(*outcome.next),
                     to_bytes(participant_data),
                     environment_.clock.monotonic(),
                     std::move(unproven)};
  pair->handshakes.reserve(pair->handshakes.size() + 1);
  const auto handle = kept.handle = table_.add_handshake(pair);
  make_room(*pair);
  pair->handshakes.push_back(std::move(kept));
  return {handle, outcome.result, std::move(outcome.message)};
}

Result<PkiDh::HandshakeStep> PkiDh::begin_handshake_request(IdentityHandle initiator,
                                                            IdentityHandle replier,
                                                            BytesView participant_data) {
  return reported(request(initiator, replier, participant_data), replier);
}

Status check_participant_data_size(BytesView participant_data) {
  if (!participant_data.empty() && participant_data.size() <= kMostParticipantDataOctets) return {};
  return fail(Code::token_field_length,
              {.document = "serialized participant data",
               .field = "c.pdata",
               .expected = "1 to " + std::to_string(kMostParticipantDataOctets) + " octets",
               .found = std::to_string(participant_data.size()) + " octets"});
}

Result<PkiDh::HandshakeStep> PkiDh::request(IdentityHandle local, IdentityHandle remote,
                                            BytesView participant_data) {
  DDSSEC_RETURN_IF_ERROR(check_participant_data_size(participant_data));
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair(local, remote));
  DDSSEC_RETURN_IF_ERROR(
      check_role(initiates(pair->local->guid(), pair->remote_guid), "begin_handshake_request"));
  const std::scoped_lock lock(pair->mutex);
  for (const auto& handshake : pair->handshakes) {
    const auto* waiting = std::get_if<AwaitReply>(&handshake.state);
    if (waiting != nullptr && may_go_on(*pair, handshake, waiting->own) &&
        std::ranges::equal(handshake.participant_data, participant_data))
      return HandshakeStep{handshake.handle, ValidationResult::pending_handshake_message,
                           waiting->request};
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto what, context(*pair));
  DDSSEC_RETURN_IF_ERROR(check_room(*pair));
  DDSSEC_ASSIGN_OR_RETURN(auto request, start_request(what, participant_data));
  return keep(pair, std::move(request), participant_data);
}

Result<PkiDh::HandshakeStep> PkiDh::begin_handshake_reply(const Token& request,
                                                          IdentityHandle initiator,
                                                          IdentityHandle replier,
                                                          BytesView participant_data) {
  return reported(reply(request, replier, initiator, participant_data), initiator);
}

Result<PkiDh::HandshakeStep> PkiDh::reply(const Token& request, IdentityHandle local,
                                          IdentityHandle remote, BytesView participant_data) {
  DDSSEC_RETURN_IF_ERROR(check_participant_data_size(participant_data));
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair(local, remote));
  DDSSEC_RETURN_IF_ERROR(
      check_role(!initiates(pair->local->guid(), pair->remote_guid), "begin_handshake_reply"));
  const std::scoped_lock lock(pair->mutex);
  for (const auto& handshake : pair->handshakes) {
    if (!is_answer_to(handshake.state, request)) continue;
    const auto* waiting = std::get_if<AwaitFinal>(&handshake.state);
    if (waiting == nullptr)
      return fail(Code::unexpected_message,
                  {.document = "handshake request", .note = "after the handshake that it began"});
    if (!may_go_on(*pair, handshake, waiting->own)) continue;
    return HandshakeStep{handshake.handle, ValidationResult::pending_handshake_message,
                         waiting->reply};
  }
  DDSSEC_ASSIGN_OR_RETURN(auto what, context(*pair));
  what.reply_keys = &pair->reply_keys;
  DDSSEC_RETURN_IF_ERROR(check_room(*pair));
  DDSSEC_ASSIGN_OR_RETURN(auto outcome, start_reply(what, request, participant_data));
  DDSSEC_ASSIGN_OR_RETURN(auto share, share_of(*pair, request, outcome));
  return keep(pair, std::move(outcome), participant_data, std::move(share));
}

/// What the request makes us keep.
Result<UnprovenOctets::Share> PkiDh::share_of(const Pair& pair, const Token& request,
                                              const HandshakeOutcome& outcome) {
  std::size_t octets = 0, free = 0;
  for (const auto& property : request.binary_properties) octets += property.value.size();
  for (const auto& handshake : pair.handshakes) free += handshake.unproven.free_octets();
  const auto& peer = std::get<AwaitFinal>(*outcome.next).peer;
  auto share = unproven_.take(peer.certificate().subject_digest(), octets, free);
  if (share) return *std::move(share);
  return fail(Code::too_many_handshakes,
              {.document = "handshake request",
               .expected = "at most " + std::to_string(UnprovenOctets::kMostOfASubject) +
                           " octets of a subject in requests that wait for their end",
               .found = std::to_string(octets) + " more octets"});
}

/// Our certificate may have ended since the handshake began, if it was renewed.
Status PkiDh::note_authenticated(const Pair& pair, const Established& done) {
  DDSSEC_ASSIGN_OR_RETURN(const auto own,
                          pair.local->verify(done.own->certificate, environment_.clock.now()));
  return table_.note_authenticated(pair.remote_handle,
                                   {done.peer.chain(), own, done.peer.keeps_session()});
}

Result<PkiDh::HandshakeStep> PkiDh::process_handshake(HandshakeHandle handshake,
                                                      const Token& message) {
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, reported(table_.pair_of(handshake)));
  return reported(step(handshake, message), pair->remote_handle);
}

Result<PkiDh::HandshakeStep> PkiDh::step(HandshakeHandle handle, const Token& message) {
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair_of(handle));
  const std::scoped_lock lock(pair->mutex);
  const auto handshake = std::ranges::find(pair->handshakes, handle, &PairHandshake::handle);
  if (handshake == pair->handshakes.end()) return fail(Code::unknown_handshake);
  DDSSEC_ASSIGN_OR_RETURN(const auto what, context(*pair));
  DDSSEC_ASSIGN_OR_RETURN(auto outcome, process(handshake->state, what, message));
  if (outcome.next) {
    if (const auto* done = std::get_if<Established>(&*outcome.next))
      DDSSEC_RETURN_IF_ERROR(note_authenticated(*pair, *done));
    static_assert(std::is_nothrow_move_assignable_v<HandshakeState>);
    handshake->state = std::move(*outcome.next);
    if (!is_pending(*handshake)) handshake->unproven = {};
  }
  return HandshakeStep{handle, outcome.result, std::move(outcome.message)};
}

template <class F>
auto PkiDh::established(HandshakeHandle handle, F&& f) const
    -> Result<std::invoke_result_t<F, const Established&>> {
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair_of(handle));
  const std::scoped_lock lock(pair->mutex);
  const auto handshake = std::ranges::find(pair->handshakes, handle, &PairHandshake::handle);
  if (handshake == pair->handshakes.end()) return fail(Code::unknown_handshake);
  const auto* done = std::get_if<Established>(&handshake->state);
  if (done == nullptr) return fail(Code::handshake_not_finished);
  return f(*done);
}

Result<std::shared_ptr<const spi::SharedSecret>> PkiDh::shared_secret(HandshakeHandle handshake) {
  return reported(established(handshake, [](const Established& done) { return done.secret; }));
}

Result<Token> PkiDh::authenticated_peer_credential_token(HandshakeHandle handshake) {
  const auto with_facts = [](const Established& done) {
    auto credential = done.peer.credential();
    if (credential)
      spi::add_session_facts(*credential, {.presented_permissions = sha256(done.own->permissions),
                                           .peer_keeps_session = done.peer.keeps_session()});
    return credential;
  };
  DDSSEC_ASSIGN_OR_RETURN(auto credential, reported(established(handshake, with_facts)));
  if (!credential) return reported(Result<Token>(fail(Code::credential_given_out)));
  const std::scoped_lock lock(given_out_mutex_);
  if (std::ranges::find(given_out_, handshake) == given_out_.end()) given_out_.push_back(handshake);
  return *std::move(credential);
}

std::string PkiDh::authenticated_subject(HandshakeHandle handshake) {
  return established(
             handshake,
             [](const Established& done) { return done.peer.chain().certificate().subject(); })
      .value_or(std::string());
}

/// Not at once: a host that had no memory for it asks again.
void PkiDh::drop_credentials_given_out() {
  std::vector<HandshakeHandle> handles;
  {
    const std::scoped_lock lock(given_out_mutex_);
    handles.swap(given_out_);
  }
  for (const auto handle : handles) {
    const auto pair = table_.pair_of(handle);
    if (!pair) continue;
    const std::scoped_lock lock((*pair)->mutex);
    const auto handshake = std::ranges::find((*pair)->handshakes, handle, &PairHandshake::handle);
    if (handshake == (*pair)->handshakes.end()) continue;
    if (auto* const done = std::get_if<Established>(&handshake->state))
      done->peer.drop_credential();
  }
}

Status PkiDh::return_handshake_handle(HandshakeHandle handle) {
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair_of(handle));
  const std::scoped_lock lock(pair->mutex);
  table_.remove_handshake(handle);
  std::erase_if(pair->handshakes, [&](const auto& h) { return h.handle == handle; });
  return {};
}

}  // namespace

std::unique_ptr<spi::Authentication> make_authentication(const Environment& environment,
                                                         Options options) {
  return std::make_unique<PkiDh>(environment, options);
}

}  // namespace ddssec::authentication
