#include "rtps/security/handshakes.hpp"

#include <algorithm>

namespace ddssec::rtps {
namespace {

// An attacker can announce addresses of other hosts. A peer that has sent nothing gets messages at
// the addresses from which it announced itself, and at one of the other addresses in turn.
LocatorList addresses_of(const Peer& peer) {
  const auto& all = peer.metatraffic;
  if (peer.has_spoken || peer.state.association() != nullptr ||
      peer.announced_by.size() != all.size())
    return all;
  LocatorList out, others;
  for (std::size_t i = 0; i < all.size(); ++i)
    (SourceAddress(all[i]) == peer.announced_by[i] ? out : others).push_back(all[i]);
  const auto turn = static_cast<std::size_t>(peer.state.handshake()->repetitions());
  if (!others.empty()) out.push_back(others[turn % others.size()]);
  return out;
}

// Removes answers to the peer whose answers take the most, until there is room for another one.
void make_room_for_answer(SecurityCore& core, const HandshakeAccount& account) {
  const auto taken = [](const auto& one) {
    auto* const handshake = one.second.state.handshake();
    return handshake == nullptr ? 0 : handshake->answers().octets();
  };
  while (account.answer_octets >= Handshakes::kMaxAnswerOctets) {
    const auto largest = std::ranges::max_element(core.peers, {}, taken);
    if (largest == core.peers.end() || taken(*largest) == 0) return;
    largest->second.state.handshake()->answers().evict_largest();
  }
}

// Of this data, the plugin has read only what it decides about itself.
Result<ParticipantData> read_signed_data(const Peer& peer) {
  const auto document = "the participant data that " + peer.name() + " signed";
  auto data = read_participant_list(peer.state.handshake()->peer_data(), Endian::big);
  if (!data) return std::unexpected(data.error().with_default_document(document));
  if (data->guid != peer.data.guid)
    return fail(Code::rtps_parameter_invalid, {.document = document,
                                               .field = "PARTICIPANT_GUID",
                                               .expected = peer.data.guid.to_string(),
                                               .found = data->guid.to_string()});
  return data;
}

MonotonicTime pause_after_refusal(const Peer& peer) {
  constexpr int kMaxDoublings = 4;
  const auto pause = Handshakes::kMinRefusedPause * (1 << std::min(peer.refusals, kMaxDoublings));
  return std::min<MonotonicTime>(pause, Handshakes::kMaxRefusedPause);
}

// Claims a place. It is released when the result is destroyed.
Cleanup place_of(SubjectShares& subjects, const GuidPrefix& prefix) {
  subjects.claim(prefix);
  return Cleanup([&subjects, prefix] { subjects.release(prefix); });
}

}  // namespace

std::unique_ptr<PeerHandshake> Handshakes::handshake_with(const ParticipantData& data) {
  auto& own = *core_.own;
  return std::make_unique<PeerHandshake>(
      own.plugins().authentication,
      PeerHandshake::Sides{own.guid(), data.guid, own.identity(),
                           data.identity_token.value_or(spi::Token{}),
                           data.vendor != kVendorFastDds, data.vendor == kVendorDdssec,
                           key_reviser_.identity_of_absent(data.guid.prefix)},
      core_.own_data(), account_, core_.now);
}

void Handshakes::add(const ParticipantData& data, const AnnouncedAddresses& addresses) {
  const auto [at, is_new] =
      core_.peers.emplace(data.guid.prefix, Peer{.data = data,
                                                 .metatraffic = addresses.metatraffic,
                                                 .state = PeerState(handshake_with(data)),
                                                 .low_rate_budget = HandshakeBudgets::low_rate(),
                                                 .source = addresses.source});
  at->second.announced_by.assign(addresses.sources.begin(), addresses.sources.end());
  if (is_new) schedule(at->second);
}

// An attacker can send announcements in any name, and may have sent the first one. So a handshake
// that failed begins again with the current one, and a running one goes on at both addresses.
void Handshakes::announced_again(const ParticipantData& data, const AnnouncedAddresses& addresses) {
  auto* peer = core_.find(data.guid.prefix);
  if (peer == nullptr || peer->state.association() != nullptr) return;
  const bool moves = peer->metatraffic != addresses.metatraffic;
  peer->metatraffic = addresses.metatraffic;
  peer->announced_by.assign(addresses.sources.begin(), addresses.sources.end());
  peer->source = addresses.source;
  if (auto* handshake = peer->state.handshake()) {
    if (data.vendor == kVendorDdssec) handshake->note_repeats_challenges();
    if (moves && budgets_.may_repeat_unasked(peer->source, core_.now))
      handshake->repeat_by(core_.now);
    schedule(*peer);
  }
  if (!peer->state.is<peer::Refused>()) return;
  peer->data = data;
  try_again(*peer);
}

// Messages may have been held up for long, so that they have become rare.
void Handshakes::note_announced(Peer& peer) {
  peer.was_announced = true;
  auto* handshake = peer.state.handshake();
  if (handshake == nullptr) return;
  handshake->note_sign(core_.now);
  schedule(peer);
}

void Handshakes::try_again(Peer& peer) {
  if (!peer.state.is<peer::Refused>()) return;
  peer.next_attempt_at = core_.now + kMinRefusedPause;
  if (!budgets_.may_begin(peer.source, core_.now)) return;
  peer.state.on_another_announcement(handshake_with(peer.data));
  schedule(peer);
}

void Handshakes::try_all_again() {
  for (auto& [prefix, peer] : core_.peers) {
    peer.refusals = 0;
    peer.next_attempt_at = core_.now;
    schedule(peer);
  }
}

// ---- messages

// Each message is sent separately, so that in a flood each has its own chance to be processed. A
// message that may not be sent yet is held back until the peer sends more. An answer is not held
// back; the peer has to request it again.
void Handshakes::send(Peer& peer, const PeerHandshake::Messages& messages) {
  const auto& handshake = *peer.state.handshake();
  const auto addresses = addresses_of(peer);
  const auto send_one = [&](const GenericMessage& message) {
    const bool is_auth_request = message.message_class == message_class::kAuthRequest;
    return is_auth_request && handshake.repeats_challenges()
               ? messages_.send_auth_request(peer, message, addresses)
               : messages_.send(peer, message, addresses);
  };
  core_.sender.flush_now();
  peer.deferred_octets = peer.expected_answer_octets = 0;
  bool has_asked = false;
  for (const auto& message : messages) {
    has_asked |= message.message_class == message_class::kAuthRequest;
    const auto held_back = send_one(message);
    if (handshake.is_initiator()) peer.deferred_octets = std::max(peer.deferred_octets, held_back);
  }
  if (peer.deferred_octets == 0) return;
  const auto own = handshake.auth_request();
  if (handshake.repeats_challenges() && !has_asked && own) send_one(*own);
  messages_.add_credit(peer, addresses);
}

void Handshakes::note_credit(Peer& peer, std::size_t octets) {
  auto* handshake = peer.state.handshake();
  if (peer.deferred_octets == 0 || handshake == nullptr) return;
  const auto addresses = addresses_of(peer);
  peer.expected_answer_octets -= std::min(peer.expected_answer_octets, octets);
  if (peer.deferred_octets > core_.sender.amplification_limit().left(peer.prefix(), addresses))
    return messages_.add_credit(peer, addresses);
  peer.deferred_octets = 0;
  peer.may_send_deferred = true;
  handshake->start_at(core_.now);
  schedule(peer);
}

void Handshakes::on_stateless(const GuidPrefix& source, BytesView payload) {
  auto* peer = core_.find(source);
  if (peer == nullptr) return;
  // The sender may have new documents, or may only repeat itself. So the refused peer gets another
  // try, but not sooner than after a pause.
  const auto pause =
      std::max<MonotonicTime>(kMinRefusedPause, (peer->next_attempt_at - peer->refused_at) / 4);
  if (core_.now >= peer->refused_at + pause) try_again(*peer);
  auto* handshake = peer->state.handshake();
  if (handshake == nullptr) return;
  const auto message = read_generic_message(payload);
  const bool ours = message && message->identity.source.prefix == source &&
                    message->destination_participant == core_.own->guid();
  if (!ours) return;
  if (!handshake->is_started() && !has_place(*peer)) return;
  handshake->note_heard();
  handshake->note_sign(core_.now);
  if (!std::exchange(peer->has_spoken, true) && !handshake->is_started())
    handshake->start_at(core_.now);
  if (message->message_class == message_class::kAuthRequest)
    on_auth_request(*peer, *message);
  else if (message->message_class == message_class::kAuthentication)
    on_authentication(*peer, *message);
  schedule(*peer);
}

void Handshakes::on_stateless_frag(const GuidPrefix& source, const DataFrag& frag,
                                   const SourceAddress& from) {
  if (core_.find(source) == nullptr) return;
  for (const auto& whole : fragments_.add(source, frag, core_.now, from))
    on_stateless(source, whole);
}

// The peer waits for a handshake request. If its handshake is already finished, the peer may have
// lost its state. But an attacker may also have sent this in its name, while the peer still answers
// with its present keys.
void Handshakes::on_auth_request(Peer& peer, const GenericMessage& message) {
  auto& handshake = *peer.state.handshake();
  PeerHandshake::Messages out;
  const auto repeated = handshake.receive_auth_request(message, out);
  if (core_.sender.amplification_limit().prove(peer.prefix(), repeated)) note_credit(peer, 0);
  if (!out.empty()) send(peer, out);
  if (!handshake.is_initiator()) return;
  if (peer.state.association() == nullptr) return request_resend(peer);
  const auto* joined = peer.state.joined();
  if (joined == nullptr || core_.now < joined->next_probe) return;
  // A peer that has proven the end of the session has no keys to answer with.
  const bool has_ended = core_.own->session_ends().has_ended(peer.prefix());
  peer.state.on_auth_request(core_.now + (has_ended ? MonotonicTime::zero() : kProbeTimeout),
                             core_.now + kProbePeriod);
  if (!has_ended) exchange_.probe(peer);
}

void Handshakes::on_authentication(Peer& peer, const GenericMessage& message) {
  auto& handshake = *peer.state.handshake();
  const auto assessment = handshake.assess(message);
  if (assessment.effort == Effort::none) return;
  PeerHandshake::Messages out;
  if (assessment.effort == Effort::request) make_room_for_answer(core_, account_);
  const bool taken =
      may_spend(peer, assessment.effort) && handshake.receive(message, assessment, core_.now, out);
  if (handshake.is_started()) peer.state.on_handshake_begun();
  if (!taken) return request_resend(peer);
  if (handshake.refusals() > 0 && peer.state.association() == nullptr) note_failure(peer);
  // A final message is sent once the keys are ready for what the peer sends next.
  const bool is_new = advance(peer);
  if (!peer.state.is<peer::Refused>()) send(peer, out);
  if (is_new && !exchange_.open(peer)) refuse(peer);
}

// Public-key work is limited before anything is proven. In a flood, peers that send little have a
// share of their own. In a flood in the name of an honest peer, its messages are processed as often
// as any other.
bool Handshakes::may_spend(Peer& peer, Effort effort) {
  const bool is_low_rate = effort != Effort::memory && peer.low_rate_budget.try_spend(core_.now) &&
                           !peer.was_counted_as_failed;
  return budgets_.may_process(effort, is_low_rate, core_.now);
}

// A message of the peer was dropped. If the local message is repeated soon, the peer sends the
// dropped one again, which may then be processed.
void Handshakes::request_resend(const Peer& peer) {
  if (budgets_.may_request_resend(core_.now)) peer.state.handshake()->shorten_delays(core_.now);
}

// ---- state transitions

bool Handshakes::advance(Peer& peer) {
  auto& handshake = *peer.state.handshake();
  if (handshake.is_started()) peer.state.on_handshake_begun();
  if (handshake.failure()) {
    refuse(peer);
    return false;
  }
  if (!handshake.take_proof()) return false;
  // The peer has begun another session, so it does not return to the one that is kept.
  dormant_.drop(peer.prefix());
  const bool had_keys = peer.state.association() != nullptr;
  const bool had_endpoint_keys = peer.state.joined() != nullptr;
  const bool was_admitted = peer.state.is_admitted();
  if (had_keys) core_.host.on_replaced(GuidPrefix(peer.prefix()));
  if (!peer.state.on_handshake_finished()) return false;
  auto association = associate(peer);
  if (!association) {
    if (had_keys) key_reviser_.request();
    if (spi::refusal_passes(association.error().code()))
      try_later(peer);
    else
      refuse(peer);
    return false;
  }
  // Until here the peer took part as before, so a refusal interrupts nothing.
  if (was_admitted) core_.host.on_replaced(GuidPrefix(peer.prefix()));
  // The peer has earlier keys of local endpoints, whether it left or not. It may have fewer rights,
  // but no peer has lost trust.
  key_reviser_.drop_absent(peer.prefix(), KeyReviser::RevisionReason::right_lost);
  if (had_endpoint_keys) key_reviser_.request(KeyReviser::RevisionReason::right_lost);
  fragments_.forget(peer.prefix());
  core_.sender.amplification_limit().end(peer.prefix());
  return peer.state.on_permissions_validated(std::move(*association), core_.now);
}

Result<Association> Handshakes::associate(Peer& peer) {
  const auto prefix = peer.prefix();
  if (!subjects_.has_place(prefix)) return std::unexpected(no_place_error(peer));
  DDSSEC_RETURN_IF_ERROR(adopt_proven_data(peer));
  Association out;
  DDSSEC_ASSIGN_OR_RETURN(out.permissions, permissions_of(peer));
  out.subject =
      core_.own->plugins().authentication.authenticated_subject(peer.state.handshake()->handle());
  DDSSEC_RETURN_IF_ERROR(register_keys(peer, out));
  out.place = place_of(subjects_, prefix);
  return out;
}

bool Handshakes::wake(Peer peer) {
  const auto prefix = peer.prefix();
  if (!subjects_.has_place(prefix)) {
    key_reviser_.note_absent(peer);
    return false;
  }
  peer.state.association()->place = place_of(subjects_, prefix);
  peer.state.on_keys_timeout(core_.now);
  schedule(core_.peers.emplace(prefix, std::move(peer)).first->second);
  return true;
}

// ---- the share of each certificate

bool Handshakes::has_place(const Peer& peer) const {
  return peer.state.association() != nullptr || subjects_.has_place(peer.prefix());
}

// The event is raised before the peer counts as failed, and so once for each peer.
Error Handshakes::no_place_error(const Peer& peer) {
  Error error(Code::too_many_identities_of_subject,
              {.document = "the certificate of participant " + peer.name(),
               .expected = "no more participants than places are free",
               .found = "one more than " + std::to_string(subjects_.count(peer.prefix()))});
  if (!peer.was_counted_as_failed) core_.raise(error, peer, EventOrigin::its_keys);
  return error;
}

void Handshakes::try_later(Peer& peer) {
  peer.state.on_refusal(peer.state.is_admitted());
  note_failure(peer);
  auto handshake = handshake_with(peer.data);
  handshake->start_at(core_.now + PeerHandshake::kResend);
  peer.state.on_another_announcement(std::move(handshake));
}

Result<PeerPermissions> Handshakes::permissions_of(const Peer& peer) {
  auto& [authentication, access_control, cryptography] = core_.own->plugins();
  const auto& handshake = *peer.state.handshake();
  DDSSEC_ASSIGN_OR_RETURN(const auto credential,
                          authentication.authenticated_peer_credential_token(handshake.handle()));
  DDSSEC_ASSIGN_OR_RETURN(const auto handle,
                          access_control.validate_remote_permissions(
                              core_.own->identity(), handshake.identity()->handle(),
                              peer.data.permissions_token.value_or(spi::Token{}), credential));
  PeerPermissions out{handle, Cleanup([&plugin = access_control, handle] {
                        static_cast<void>(plugin.return_permissions_handle(handle));
                      })};
  DDSSEC_RETURN_IF_ERROR(access_control.check_remote_participant(handle, core_.own->domain_id()));
  return out;
}

Status Handshakes::register_keys(const Peer& peer, Association& association) {
  const auto& handshake = *peer.state.handshake();
  const auto prefix = peer.prefix();
  DDSSEC_ASSIGN_OR_RETURN(auto secret,
                          core_.own->plugins().authentication.shared_secret(handshake.handle()));
  // Resets are specific to our plugins, and only these announce this cipher.
  if ((secret->peer_ciphers & spi::kChaCha20Poly1305Bit) != 0)
    association.reset = spi::derive_reset_token(*secret, core_.own->guid().prefix);
  auto& keyring = core_.keyring;
  DDSSEC_RETURN_IF_ERROR(keyring.add_remote(
      prefix, {handshake.identity()->handle(), association.permissions.handle, std::move(secret),
               peer.data.vendor != kVendorCyclone, peer.answers_key_requests}));
  association.keys = Cleanup([&sender = core_.sender, &keyring, prefix] {
    sender.flush_now();  // waiting messages need its keys
    keyring.remove_remote(prefix);
  });
  DDSSEC_RETURN_IF_ERROR(
      keyring.register_pair(kVolatileMessageWriter, {prefix, kVolatileMessageReader}));
  DDSSEC_RETURN_IF_ERROR(
      keyring.register_pair(kVolatileMessageReader, {prefix, kVolatileMessageWriter}));
  return {};
}

// Both sides have signed this data, whereas unprotected announcements can be forged. So if it
// cannot be read, the peer is refused, and its announcement is not used instead.
Status Handshakes::adopt_proven_data(Peer& peer) {
  peer.answers_key_requests = false;
  const auto proven = read_signed_data(peer);
  if (!proven) {
    if (!peer.was_counted_as_failed) core_.raise(proven.error(), peer, EventOrigin::its_keys);
    return std::unexpected(proven.error());
  }
  DDSSEC_RETURN_IF_ERROR(admission_.check_proven(*proven));
  if (proven->vendor != VendorId{}) peer.data.vendor = proven->vendor;
  // The version that was the first to mark ends was also the first to answer.
  peer.answers_key_requests = peer.data.vendor == kVendorDdssec &&
                              find_property(proven->properties, kMarksEndsProperty) != nullptr;
  if (proven->permissions_token) peer.data.permissions_token = proven->permissions_token;
  if (auto proven_at = core_.host.on_proven(GuidPrefix(peer.prefix()), *proven); !proven_at.empty())
    peer.metatraffic = std::move(proven_at);
  return {};
}

void Handshakes::refuse(Peer& peer) {
  const bool was_admitted = peer.state.is_admitted();
  if (peer.state.association() != nullptr) key_reviser_.request();
  if (!peer.state.on_refusal(admission_.admits_unauthenticated())) return;
  note_failure(peer);
  peer.refused_at = core_.now;
  peer.next_attempt_at = core_.now + pause_after_refusal(peer);
  ++peer.refusals;
  schedule(peer);
  if (!was_admitted) core_.host.on_unauthenticated(GuidPrefix(peer.prefix()));
}

void Handshakes::note_key_exchange(Peer& peer) {
  if (peer.state.on_key_exchange_message()) schedule(peer);
}

}  // namespace ddssec::rtps
