#include <functional>

#include "plugins/authentication/participant_data.hpp"
#include "plugins/authentication/pki_dh.hpp"

namespace ddssec::authentication {
namespace {

Status check_role(bool is_right, std::string_view call) {
  if (is_right) return {};
  return fail(Code::handshake_role_wrong, {.field = std::string(call)});
}

// The largest number of finished handshakes of one pair about which the host can still ask.
constexpr std::size_t kMaxFinishedPerPair = 4;

bool is_pending(const PairHandshake& handshake) {
  return !std::holds_alternative<EstablishedSession>(handshake.state);
}

Status check_participant_data_size(BytesView participant_data) {
  if (!participant_data.empty() && participant_data.size() <= kMaxParticipantDataOctets) return {};
  return fail(Code::token_field_length,
              {.document = "serialized participant data",
               .field = "c.pdata",
               .expected = "1 to " + std::to_string(kMaxParticipantDataOctets) + " octets",
               .found = std::to_string(participant_data.size()) + " octets"});
}

}  // namespace

Result<HandshakeContext> PkiDh::handshake_context(const IdentityPair& pair) const {
  const WallTime now = services_.clock.calendar_seconds();
  DDSSEC_RETURN_IF_ERROR(pair.local->verify(now));
  return HandshakeContext{*pair.local, pair.remote_guid, pair.own_challenge,
                          pair.announced_challenge, now};
}

// Takes up the request that was kept for the pair. The caller holds the pair's lock.
void PkiDh::restore_kept_request(const std::shared_ptr<IdentityPair>& pair) {
  auto [request, reply_keys] = kept_requests_.take(pair->local_handle, pair->remote_guid);
  pair->reply_keys = std::move(reply_keys);
  if (!request) return;
  pair->handshakes.reserve(pair->handshakes.size() + 1);
  request->handle = table_.add_handshake(pair);
  pair->handshakes.push_back(std::move(*request));
}

// A handshake that is under way continues with the documents with which it began. If these were
// renewed since, it may continue for kPendingAge. After that the same message begins another
// handshake.
bool PkiDh::may_continue(const IdentityPair& pair, const PairHandshake& handshake,
                         const std::shared_ptr<const PresentedDocuments>& own) const {
  return own == pair.local->presented() ||
         services_.clock.monotonic() - handshake.began_at < kPendingAge;
}

// Only a handshake that has waited long is dropped for another one.
Status PkiDh::check_room(const IdentityPair& pair) const {
  const auto& all = pair.handshakes;
  const auto pending = std::ranges::count_if(all, is_pending);
  if (static_cast<std::size_t>(pending) < kMaxPendingPerPair) return {};
  const auto oldest = std::ranges::find_if(all, is_pending);
  if (services_.clock.monotonic() - oldest->began_at >= kPendingAge) return {};
  return fail(Code::too_many_handshakes,
              {.expected = "at most " + std::to_string(kMaxPendingPerPair)});
}

void PkiDh::make_room(IdentityPair& pair) {
  auto& all = pair.handshakes;
  const auto drop_first = [&](auto&& is_one) {
    const auto first = std::ranges::find_if(all, is_one);
    if (first == all.end()) return;
    table_.remove_handshake(first->handle);
    all.erase(first);
  };
  const auto pending = static_cast<std::size_t>(std::ranges::count_if(all, is_pending));
  if (pending >= kMaxPendingPerPair) drop_first(is_pending);
  // The host has shared pointers to the parts of finished handshakes that it needs.
  if (all.size() - pending >= kMaxFinishedPerPair) drop_first(std::not_fn(is_pending));
}

PkiDh::HandshakeStep PkiDh::keep(const std::shared_ptr<IdentityPair>& pair,
                                 HandshakeOutcome outcome, BytesView participant_data,
                                 UnprovenOctets::Share unproven) {
  PairHandshake kept{{},
                     std::move(*outcome.next),
                     to_bytes(participant_data),
                     services_.clock.monotonic(),
                     std::move(unproven)};
  pair->handshakes.reserve(pair->handshakes.size() + 1);
  const auto handle = kept.handle = table_.add_handshake(pair);
  kept.unproven.assign_to(handle);
  make_room(*pair);
  pair->handshakes.push_back(std::move(kept));
  return {handle, outcome.result, std::move(outcome.message)};
}

Token PkiDh::presented_token(const Token& message, const IdentityPair& pair,
                             const PresentedDocuments& own) const {
  return with_ocsp_response(message, *pair.local, own, services_.clock.calendar_seconds());
}

PkiDh::Outline PkiDh::outline(const Token& message) const {
  const auto octets = [&](std::string_view name) {
    const auto* found = spi::find_binary_property(message, name);
    return found == nullptr ? BytesView() : BytesView(*found);
  };
  Outline out{.challenge1 = octets(kChallenge1),
              .challenge2 = octets(kChallenge2),
              .participant_data = octets(kParticipantDataName)};
  const auto claimed = claimed_class_of(message.class_id);
  if (claimed == TokenClass::request) out.kind = Outline::Kind::request;
  if (claimed == TokenClass::reply) out.kind = Outline::Kind::reply;
  if (claimed == TokenClass::final) out.kind = Outline::Kind::final;
  return out;
}

Result<PkiDh::HandshakeStep> PkiDh::begin_handshake_request(IdentityHandle initiator,
                                                            IdentityHandle replier,
                                                            BytesView participant_data) {
  return reported(begin_request(initiator, replier, participant_data), replier);
}

Result<PkiDh::HandshakeStep> PkiDh::begin_request(IdentityHandle local, IdentityHandle remote,
                                                  BytesView participant_data) {
  DDSSEC_RETURN_IF_ERROR(check_participant_data_size(participant_data));
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair(local, remote));
  DDSSEC_RETURN_IF_ERROR(
      check_role(initiates(pair->local->guid(), pair->remote_guid), "begin_handshake_request"));
  const std::scoped_lock lock(pair->mutex);
  for (const auto& handshake : pair->handshakes) {
    const auto* waiting = std::get_if<AwaitReply>(&handshake.state);
    if (waiting != nullptr && may_continue(*pair, handshake, waiting->own) &&
        std::ranges::equal(handshake.participant_data, participant_data))
      return HandshakeStep{handshake.handle, ValidationResult::pending_handshake_message,
                           presented_token(waiting->request, *pair, *waiting->own)};
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto what, handshake_context(*pair));
  DDSSEC_RETURN_IF_ERROR(check_room(*pair));
  DDSSEC_ASSIGN_OR_RETURN(auto request, start_request(what, participant_data));
  return keep(pair, std::move(request), participant_data);
}

Result<PkiDh::HandshakeStep> PkiDh::begin_handshake_reply(const Token& request,
                                                          IdentityHandle initiator,
                                                          IdentityHandle replier,
                                                          BytesView participant_data) {
  return reported(begin_reply(request, replier, initiator, participant_data), initiator);
}

Result<PkiDh::HandshakeStep> PkiDh::begin_reply(const Token& request, IdentityHandle local,
                                                IdentityHandle remote, BytesView participant_data) {
  DDSSEC_RETURN_IF_ERROR(check_participant_data_size(participant_data));
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair(local, remote));
  DDSSEC_RETURN_IF_ERROR(
      check_role(!initiates(pair->local->guid(), pair->remote_guid), "begin_handshake_reply"));
  auto step = answer_request(pair, request, participant_data);
  // The caller holds no lock of a pair, because the handshakes to drop belong to other pairs.
  if (step) drop_excess(step->handle);
  return step;
}

Result<PkiDh::HandshakeStep> PkiDh::answer_request(const std::shared_ptr<IdentityPair>& pair,
                                                   const Token& request,
                                                   BytesView participant_data) {
  const std::scoped_lock lock(pair->mutex);
  for (const auto& handshake : pair->handshakes) {
    if (!is_answer_to(handshake.state, request)) continue;
    const auto* waiting = std::get_if<AwaitFinal>(&handshake.state);
    if (waiting == nullptr)
      return fail(Code::unexpected_message,
                  {.document = "handshake request", .note = "after the handshake that it began"});
    if (!may_continue(*pair, handshake, waiting->own)) continue;
    return HandshakeStep{handshake.handle, ValidationResult::pending_handshake_message,
                         presented_token(waiting->reply, *pair, *waiting->own)};
  }
  DDSSEC_ASSIGN_OR_RETURN(auto what, handshake_context(*pair));
  what.reply_keys = &pair->reply_keys;
  DDSSEC_RETURN_IF_ERROR(check_room(*pair));
  DDSSEC_ASSIGN_OR_RETURN(auto outcome, start_reply(what, request, participant_data));
  auto share = share_of(*pair, request, outcome);
  return keep(pair, std::move(outcome), participant_data, std::move(share));
}

// Claims the memory that the request makes us keep.
UnprovenOctets::Share PkiDh::share_of(const IdentityPair& pair, const Token& request,
                                      const HandshakeOutcome& outcome) {
  std::size_t octets = 0, free = 0;
  for (const auto& property : request.binary_properties) octets += property.value.size();
  for (const auto& handshake : pair.handshakes) free += handshake.unproven.free_octets();
  const auto& peer = std::get<AwaitFinal>(*outcome.next).peer;
  return unproven_.claim(peer.certificate().subject_digest(), octets, free);
}

// The host then finds that the handle of a dropped handshake is unknown, and starts another
// handshake.
void PkiDh::drop_excess(HandshakeHandle newest) {
  for (const auto handle : unproven_.excess(services_.random, newest)) {
    const auto pair = table_.pair_of(handle);
    if (!pair) continue;
    {
      const std::scoped_lock lock((*pair)->mutex);
      const auto is_it = [&](const auto& one) { return one.handle == handle && is_pending(one); };
      if (std::erase_if((*pair)->handshakes, is_it) == 0) continue;
      table_.remove_handshake(handle);
    }
    const Result<void> dropped =
        fail(Code::too_many_handshakes,
             {.document = "handshake request",
              .expected = "at most " + std::to_string(UnprovenOctets::kMaxOfASubject) +
                          " octets of a subject in requests that wait for their end, and " +
                          std::to_string(UnprovenOctets::kMax) + " of all",
              .found = "more; this handshake is dropped, and another one begins"});
    static_cast<void>(reported(dropped, (*pair)->remote_handle));
  }
}

// If our certificate was renewed, the one of this handshake may have ended since it began.
Status PkiDh::note_authenticated(const IdentityPair& pair, const EstablishedSession& done) {
  DDSSEC_ASSIGN_OR_RETURN(const auto own, pair.local->verify(done.own->certificate,
                                                             services_.clock.calendar_seconds()));
  return table_.set_authenticated(
      pair.remote_handle,
      {done.peer.chain(), own, done.peer.keeps_session(), done.peer.reads_lists()});
}

// The peer is proven, but its response is not, because it is not signed.
void PkiDh::note_unused_ocsp(const IdentityPair& pair, const EstablishedSession& done) const {
  const auto& why = done.peer.ocsp_unused();
  if (!why) return;
  auto details = why->details();
  details.hint.clear();
  const auto reason = std::string(info(why->code()).summary);
  details.note = details.note.empty() ? reason : reason + "; " + details.note;
  services_.events.raise(event_about(table_.name_of(pair.remote_handle),
                                     Error(Code::ocsp_status_unused, std::move(details))));
}

Result<PkiDh::HandshakeStep> PkiDh::process_handshake(HandshakeHandle handshake,
                                                      const Token& message) {
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, reported(table_.pair_of(handshake)));
  return reported(process_step(handshake, message), pair->remote_handle);
}

Result<PkiDh::HandshakeStep> PkiDh::process_step(HandshakeHandle handle, const Token& message) {
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair_of(handle));
  const std::scoped_lock lock(pair->mutex);
  const auto handshake = std::ranges::find(pair->handshakes, handle, &PairHandshake::handle);
  if (handshake == pair->handshakes.end()) return fail(Code::unknown_handshake);
  DDSSEC_ASSIGN_OR_RETURN(const auto what, handshake_context(*pair));
  DDSSEC_ASSIGN_OR_RETURN(auto outcome, process(handshake->state, what, message));
  if (outcome.next) {
    if (const auto* done = std::get_if<EstablishedSession>(&*outcome.next)) {
      DDSSEC_RETURN_IF_ERROR(check_same_domain(
          done->peer.domain(), domain_in_participant_data(handshake->participant_data)));
      DDSSEC_RETURN_IF_ERROR(note_authenticated(*pair, *done));
    }
    static_assert(std::is_nothrow_move_assignable_v<HandshakeState>);
    handshake->state = std::move(*outcome.next);
    if (!is_pending(*handshake)) handshake->unproven = {};
    if (const auto* done = std::get_if<EstablishedSession>(&handshake->state))
      note_unused_ocsp(*pair, *done);
  }
  return HandshakeStep{handle, outcome.result, std::move(outcome.message)};
}

Status PkiDh::return_handshake_handle(HandshakeHandle handle) {
  DDSSEC_ASSIGN_OR_RETURN(const auto pair, table_.pair_of(handle));
  const std::scoped_lock lock(pair->mutex);
  table_.remove_handshake(handle);
  std::erase_if(pair->handshakes, [&](const auto& h) { return h.handle == handle; });
  return {};
}

}  // namespace ddssec::authentication
