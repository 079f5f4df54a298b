#include "rtps/security/crypto_token_exchange.hpp"

#include <algorithm>

#include "rtps/security/token_messages.hpp"

namespace ddssec::rtps {
namespace {

// Stands in WaitingTokens for the participant's own keys, and is sent before those of endpoints.
constexpr EntityId kNoEndpoint{};

Qos volatile_qos() {
  auto qos = default_writer_qos();
  qos.history.kind = HistoryKind::keep_all;
  return qos;
}

// True if the pair exists under that protection, suspended or not.
bool has_pair(SecondProtections& of, const EntityId& local, const Guid& remote,
              ProtectionId protection) {
  const auto* keys = of.find(local, protection);
  return keys != nullptr && keys->pairs.contains(remote);
}

bool may_send(const Association& association) {
  constexpr auto kMax = CryptoTokenExchange::kMaxUnacknowledgedOctets;
  return association.volatile_writer && association.volatile_writer->history().octets() < kMax;
}

// Notes that the peer has revised keys, so that its former ones end. No endpoint is named if they
// are those of messages.
void note_revised(SecurityCore& core, Peer& peer, const EntityId& local, const EntityId& remote) {
  auto& association = *peer.state.association();
  association.former_keys_end = core.now + spi::kFormerKeyLife + std::chrono::seconds(1);
  association.has_revised = true;
  const bool is_told = local != kNoEndpoint || association.revisions.try_spend(core.now);
  association.is_revision_untold |= !is_told;
  if (is_told) core.host.on_key_change(local, {peer.prefix(), remote}, KeyChange::revised);
}

}  // namespace

Status CryptoTokenExchange::open(Peer& peer) {
  auto& association = *peer.state.association();
  const auto prefix = peer.prefix();
  const auto own = core_.own->guid().prefix;
  association.volatile_writer = std::make_unique<StatefulWriter>(
      Guid{own, kVolatileMessageWriter}, volatile_qos(), core_.sender, &core_.timers);
  association.volatile_reader = std::make_unique<StatefulReader>(
      Guid{own, kVolatileMessageReader}, true, core_.sender,
      [this, prefix](Change& change) { return on_message(prefix, change); }, &core_.timers);
  association.volatile_reader->limit(kVolatileLimits);
  association.volatile_writer->match(
      {{prefix, kVolatileMessageReader}, true, false, peer.metatraffic}, core_.now);
  association.volatile_reader->match({{prefix, kVolatileMessageWriter}, true, peer.metatraffic},
                                     core_.now);
  DDSSEC_ASSIGN_OR_RETURN(auto tokens, core_.keyring.participant_tokens(prefix));
  association.governance.message_keys = core_.keyring.phases().messages().id();
  send_tokens(peer, message_class::kParticipantTokens, {}, {}, std::move(tokens));
  if (is_revising_) send_revised(peer);
  return {};
}

void CryptoTokenExchange::readdress(Peer& peer, const LocatorList& addresses) {
  peer.metatraffic = addresses;
  auto* association = peer.state.association();
  if (association == nullptr || !association->volatile_writer) return;
  association->volatile_writer->readdress({peer.prefix(), kVolatileMessageReader}, addresses,
                                          core_.now);
  association->volatile_reader->readdress({peer.prefix(), kVolatileMessageWriter}, addresses);
}

StatefulWriter* CryptoTokenExchange::volatile_writer(const GuidPrefix& prefix) {
  auto* peer = core_.find(prefix);
  auto* association = peer == nullptr ? nullptr : peer->state.association();
  if (association != nullptr) return association->volatile_writer.get();
  const auto dormant = core_.dormant.find(prefix);
  return dormant == core_.dormant.end()
             ? nullptr
             : dormant->second.peer.state.association()->volatile_writer.get();
}

StatefulReader* CryptoTokenExchange::volatile_reader(const GuidPrefix& prefix) {
  auto* peer = core_.find(prefix);
  auto* association = peer == nullptr ? nullptr : peer->state.association();
  return association == nullptr ? nullptr : association->volatile_reader.get();
}

void CryptoTokenExchange::join(Peer& peer) {
  if (!peer.state.on_participant_tokens()) return;
  core_.count_authenticated();
  if (peer.state.association() != nullptr)
    core_.raise(Error(Code::rtps_peer_authenticated), peer, EventOrigin::its_keys);
  core_.host.on_authenticated(GuidPrefix(peer.prefix()));
}

// ---- sending

void CryptoTokenExchange::send(Peer& peer, GenericMessage message) {
  auto* association = peer.state.association();
  if (association == nullptr || !association->volatile_writer) return;
  message.identity = {{core_.own->guid().prefix, kVolatileMessageWriter}, ++last_number_};
  message.destination_participant = peer.data.guid;
  Change change;
  auto octets = write_generic_message(message);
  change.payload = Payload::copy_of(octets);
  change.payload.wipe_at_end();
  wipe(octets);
  association->volatile_writer->write(std::move(change), core_.now);
}

// The peer has never acknowledged this new message, so a recorded acknowledgment does not answer
// it. If other messages to the peer are still unacknowledged, a query is as good and leaves nothing
// stored.
void CryptoTokenExchange::probe(Peer& peer) {
  if (!is_up_to_date(peer)) return ask_for_sign_of_life(peer);
  ask(peer);
}

void CryptoTokenExchange::send_notice(Peer& peer, std::string_view message_class) {
  GenericMessage message;
  message.message_class = message_class;
  send(peer, std::move(message));
}

void CryptoTokenExchange::send_tokens(Peer& peer, std::string_view message_class, const Guid& from,
                                      const Guid& to, std::vector<spi::Token> tokens) {
  if (tokens.empty()) return;
  GenericMessage message;
  message.destination_endpoint = to;
  message.source_endpoint = from;
  message.message_class = message_class;
  message.data = std::move(tokens);
  send(peer, std::move(message));
}

void CryptoTokenExchange::send_token(Peer& peer, std::string_view message_class, spi::Token token) {
  std::vector<spi::Token> tokens;
  tokens.push_back(std::move(token));
  send_tokens(peer, message_class, {}, {}, std::move(tokens));
}

// Peers of other vendors would ignore a request. It waits for room.
void CryptoTokenExchange::request_tokens(const EntityId& local, const Guid& remote) {
  auto* peer = core_.find(remote.prefix);
  if (peer == nullptr || peer->data.vendor != kVendorDdssec || !is_trusted(*peer)) return;
  add_waiting(*peer->state.association(), local, remote, std::nullopt);
  send_waiting(*peer);
}

// If the peer accepts both protections too, the message tells which one the keys are for.
void CryptoTokenExchange::send_endpoint_tokens(Peer& peer, const EntityId& local,
                                               const Guid& remote, std::vector<spi::Token> tokens,
                                               ProtectionId protection) {
  if (tokens.empty()) return;
  const bool writes = is_writer(local);
  GenericMessage message;
  message.destination_endpoint = remote;
  message.source_endpoint = {core_.own->guid().prefix, local};
  message.message_class =
      writes ? message_class::kDatawriterTokens : message_class::kDatareaderTokens;
  message.data = std::move(tokens);
  if (protection == 0) protection = core_.keyring.phases().endpoints().first_protection_of(local);
  if (protection != 0 && peer.state.association()->governance.takes_part) {
    message.message_class =
        writes ? message_class::kDatawriterTokensOfOne : message_class::kDatareaderTokensOfOne;
    message.related.sequence_number = static_cast<std::int64_t>(protection);
  }
  send(peer, std::move(message));
}

void CryptoTokenExchange::complete(Peer& peer, const EntityId& local, const Guid& remote) {
  auto completed = core_.keyring.phases().endpoints().complete(local, remote);
  if (!completed) return core_.raise(completed.error(), remote, EventOrigin::its_keys);
  if (completed->protection == 0) return;
  const bool has_keys = !completed->tokens.empty();
  send_endpoint_tokens(peer, local, remote, std::move(completed->tokens), completed->protection);
  if (is_revising_ && is_trusted(peer) && has_keys)
    add_waiting(*peer.state.association(), local, remote, spi::KeyStage::revised);
  bool is_ready = false;
  const bool any = apply_early_tokens(peer, local, remote, is_ready);
  if (is_ready) core_.host.on_keys(local, remote);
  const auto keys = core_.keyring.keys_for(local, remote);
  if (!any && keys.may_be_dropped && keys.are_second_awaited && is_trusted(peer))
    add_waiting(*peer.state.association(), local, remote, std::nullopt);
}

bool CryptoTokenExchange::complete_message_keys(Peer& peer) {
  auto& sent = peer.state.association()->governance.message_keys;
  const auto next = core_.keyring.phases().messages().next_id();
  if (sent == next) return true;
  if (!has_room(peer) || !send_message_keys(peer, next, spi::KeyStage::in_use)) return false;
  sent = next;
  if (is_revising_ && is_trusted(peer)) send_message_keys(peer, next, spi::KeyStage::revised);
  return true;
}

// A peer that waits for the keys of messages joins with those that it knows without a name.
bool CryptoTokenExchange::send_message_keys(Peer& peer, ProtectionId protection,
                                            spi::KeyStage stage) {
  auto tokens = core_.keyring.participant_tokens(peer.prefix(), protection, stage);
  if (!tokens) {
    core_.raise(tokens.error(), peer, EventOrigin::its_keys);
    return false;
  }
  if (tokens->empty()) return true;
  GenericMessage message;
  message.message_class = message_class::kParticipantTokensOfOne;
  message.related.sequence_number = static_cast<std::int64_t>(protection);
  message.data = std::move(*tokens);
  send(peer, std::move(message));
  return true;
}

bool CryptoTokenExchange::complete_pairs(Peer& peer) {
  if (!complete_message_keys(peer)) return false;
  for (const auto& [local, remote] :
       core_.keyring.phases().endpoints().incomplete_pairs(peer.prefix())) {
    if (!has_room(peer)) return false;
    complete(peer, local, remote);
  }
  note_acknowledged(peer);  // there may be room for requests
  return true;
}

// While the former protection is sent, only the second one has these keys.
void CryptoTokenExchange::send_again(Peer& peer) {
  auto& association = *peer.state.association();
  auto& phases = core_.keyring.phases();
  association.governance.message_keys = 0;
  if (core_.governance_change.is_under_way() && !phases.has_swapped())
    return phases.endpoints().send_again(peer.prefix());
  if (!is_trusted(peer)) return;
  for (const auto& [local, remote] : core_.keyring.pairs_with_keys(peer.prefix()))
    add_waiting(association, local, remote, spi::KeyStage::in_use);
  static_cast<void>(complete_message_keys(peer));
  send_waiting(peer);
}

// ---- key revision

bool CryptoTokenExchange::is_trusted(const Peer& peer) {
  const auto* association = peer.state.association();
  return association != nullptr && association->volatile_writer;
}

bool CryptoTokenExchange::is_up_to_date(const Peer& peer) {
  if (!is_trusted(peer)) return true;
  const auto& association = *peer.state.association();
  return association.volatile_writer->all_acknowledged() && association.waiting.empty();
}

void CryptoTokenExchange::set_revising(bool revising) {
  if (std::exchange(is_revising_, revising) && !revising)
    for (auto& [prefix, peer] : core_.peers)
      if (auto* association = peer.state.association()) association->waiting.end_revision();
}

void CryptoTokenExchange::send_revised(Peer& peer) {
  if (!is_trusted(peer)) return;
  auto& association = *peer.state.association();
  add_waiting(association, kNoEndpoint, {peer.prefix(), {}}, spi::KeyStage::revised);
  for (const auto& [local, remote] : core_.keyring.pairs_with_keys(peer.prefix()))
    add_waiting(association, local, remote, spi::KeyStage::revised);
  send_waiting(peer);
}

void CryptoTokenExchange::send_participant_tokens(Peer& peer, spi::KeyStage stage) {
  auto own = core_.keyring.participant_tokens(peer.prefix(), 0, stage);
  if (!own) return core_.raise(own.error(), peer, EventOrigin::its_keys);
  send_tokens(peer, message_class::kParticipantTokens, {}, {}, std::move(*own));
  const auto& messages = core_.keyring.phases().messages();
  const auto next = messages.next_id();
  if (next != messages.id() && peer.state.association()->governance.message_keys == next)
    send_message_keys(peer, next, stage);
}

// ---- waiting messages

bool CryptoTokenExchange::has_room(const Peer& peer) const {
  const auto* association = peer.state.association();
  return association != nullptr && may_send(*association);
}

void CryptoTokenExchange::note_acknowledged(Peer& peer) {
  if (is_trusted(peer)) send_waiting(peer);
}

void CryptoTokenExchange::add_waiting(Association& association, const EntityId& local,
                                      const Guid& remote, std::optional<spi::KeyStage> stage) {
  association.waiting.add(local, remote, stage);
  association.waiting.forget_unless([this](const EntityId& ours, const Guid& theirs) {
    return ours == kNoEndpoint || core_.keyring.is_pair_registered(ours, theirs);
  });
}

// Tokens are created when they are sent.
void CryptoTokenExchange::send_waiting(Peer& peer) {
  auto& association = *peer.state.association();
  auto& keyring = core_.keyring;
  while (may_send(association)) {
    const auto next = association.waiting.take();
    if (!next) return;
    const auto& [local, remote, stage] = *next;
    if (local == kNoEndpoint) {
      send_participant_tokens(peer, *stage);
      continue;
    }
    if (!keyring.is_pair_registered(local, remote)) continue;
    if (!stage) {
      send(peer, tokens_wanted({core_.own->guid().prefix, local}, remote));
      continue;
    }
    auto tokens = keyring.endpoint_tokens(local, remote, *stage);
    if (tokens)
      send_endpoint_tokens(peer, local, remote, std::move(*tokens));
    else
      core_.raise(tokens.error(), remote, EventOrigin::its_keys);
    send_second_tokens(peer, local, remote, *stage);
  }
}

// Once we send with the new protection, the peer needs no keys of the former one. Revised keys come
// after those that they take the place of.
void CryptoTokenExchange::send_second_tokens(Peer& peer, const EntityId& local, const Guid& remote,
                                             spi::KeyStage stage) {
  auto& phases = core_.keyring.phases();
  if (phases.has_swapped() || !peer.state.association()->governance.takes_part) return;
  auto& second = phases.endpoints();
  if (stage == spi::KeyStage::in_use) second.send_again(local, remote);
  complete(peer, local, remote);
  if (stage == spi::KeyStage::in_use) return;
  auto revised = second.revised_tokens(local, remote);
  if (revised)
    send_endpoint_tokens(peer, local, remote, std::move(revised->tokens), revised->protection);
  else
    core_.raise(revised.error(), remote, EventOrigin::its_keys);
}

// Without this, a refused message would wait for the peer's next HEARTBEAT.
void CryptoTokenExchange::tick() {
  for (const auto& prefix : std::exchange(have_room_, {}))
    if (auto* reader = volatile_reader(prefix)) reader->offer_again();
}

// ---- receiving

// Only the peer can have sent the message, because the key of this pair of participants protected
// it. Its content is still checked.
bool CryptoTokenExchange::on_message(const GuidPrefix& prefix, const Change& change) {
  auto* peer = core_.find(prefix);
  if (peer == nullptr || peer->state.association() == nullptr) return true;
  const auto size = change.payload.size();
  auto message = read_generic_message(change.payload.view());
  if (!message) return true;
  // Fast DDS names its stateless writer as the source.
  if (message->identity.source.prefix != prefix ||
      message->destination_participant != core_.own->guid())
    return true;
  if (const auto known = listeners_.find(message->message_class); known != listeners_.end()) {
    known->second(*peer, *message);
    return true;
  }
  if (size > kMaxTokenOctets) {
    core_.raise(Error(Code::length_out_of_range,
                      {.document = "key tokens",
                       .expected = "at most " + std::to_string(kMaxTokenOctets) + " octets",
                       .found = std::to_string(size)}),
                *peer, EventOrigin::its_keys);
    return true;
  }
  if (is_for_readers(*message) || is_for_writers(*message))
    return on_endpoint_tokens(*peer, std::move(*message), size);
  if (message->message_class == message_class::kParticipantTokens ||
      message->message_class == message_class::kParticipantTokensOfOne)
    on_participant_tokens(*peer, *message);
  if (message->message_class == message_class::kTokensWanted) on_tokens_wanted(*peer, *message);
  return true;
}

void CryptoTokenExchange::on_participant_tokens(Peer& peer, const GenericMessage& message) {
  const auto protection = protection_in(message);
  if (protection != 0 && !core_.keyring.phases().messages().has(protection)) return;
  const auto are_revised =
      core_.keyring.set_participant_tokens(peer.prefix(), message.data, protection);
  if (!are_revised) return core_.raise(are_revised.error(), peer, EventOrigin::its_keys);
  if (*are_revised) note_revised(core_, peer, {}, {});
  // The peer can read the local messages now. Messages that it could not read before are offered
  // again at once.
  if (auto* association = peer.state.association(); association->volatile_writer)
    association->volatile_writer->request_acknowledgments();
  join(peer);
}

// A peer gets no more answers than it acknowledges. Until then, repeated requests for one pair
// cause one answer.
void CryptoTokenExchange::on_tokens_wanted(Peer& peer, const GenericMessage& message) {
  const auto local = message.destination_endpoint;
  const auto remote = message.source_endpoint;
  const bool fits = local.prefix == core_.own->guid().prefix && remote.prefix == peer.prefix() &&
                    core_.keyring.is_pair_registered(local.entity, remote);
  if (!fits) return;
  auto& association = *peer.state.association();
  add_waiting(association, local.entity, remote, spi::KeyStage::in_use);
  if (is_revising_ && is_trusted(peer))
    add_waiting(association, local.entity, remote, spi::KeyStage::revised);
  send_waiting(peer);
}

// Keys may arrive before discovery announces the remote endpoint. They are kept until then.
bool CryptoTokenExchange::on_endpoint_tokens(Peer& peer, GenericMessage message,
                                             std::size_t octets) {
  const Guid local = message.destination_endpoint;
  const Guid remote = message.source_endpoint;
  const bool to_reader = is_for_readers(message);
  const bool fits = local.prefix == core_.own->guid().prefix && remote.prefix == peer.prefix() &&
                    is_reader(local.entity) == to_reader && is_writer(remote.entity) == to_reader;
  // Local endpoints exist before they are announced, so keys for an unknown one are dropped.
  if (!fits || core_.keyring.attributes(local.entity) == nullptr) return true;
  const auto protection = protection_in(message);
  if (protection != 0 && !core_.keyring.phases().endpoints().knows(local.entity, protection))
    return true;
  // The peer may be the first to add the second protection to this pair; it is added here now. The
  // tokens of a suspended pair are kept, because the peer does not send them again.
  if (protection != 0) complete(peer, local.entity, remote);
  if (has_pair(core_.keyring.phases().endpoints(), local.entity, remote, protection)) {
    if (apply_tokens(peer, message)) core_.host.on_keys(local.entity, remote);
    return true;
  }
  const bool is_kept = peer.state.association()->early.keep(std::move(message), octets, core_.now);
  // Keys of a protection that a known pair may never get must not hold up the others.
  const bool is_known = core_.keyring.kind_of(local.entity, remote) != Keyring::PairKind::unknown;
  if (!is_kept) return is_known;
  if (!is_known) core_.host.on_early_keys(local.entity, remote);
  return true;
}

bool CryptoTokenExchange::apply_early_tokens(Peer& peer, const EntityId& local, const Guid& remote,
                                             bool& is_ready) {
  auto& early = peer.state.association()->early;
  const bool any =
      early.consume({core_.own->guid().prefix, local}, remote, [&](const GenericMessage& message) {
        const auto protection = protection_in(message);
        auto& second = core_.keyring.phases().endpoints();
        if (protection != 0 && !second.knows(local, protection)) return true;
        if (protection != 0) complete(peer, local, remote);
        if (!has_pair(second, local, remote, protection)) return false;
        is_ready = apply_tokens(peer, message) || is_ready;
        return true;
      });
  if (any && (have_room_.empty() || have_room_.back() != remote.prefix))
    have_room_.push_back(remote.prefix);
  return any;
}

bool CryptoTokenExchange::apply_tokens(Peer& peer, const GenericMessage& message) {
  const auto protection = protection_in(message);
  const auto& local = message.destination_endpoint.entity;
  const auto& remote = message.source_endpoint;
  const auto* keys = core_.keyring.phases().endpoints().find(local, protection);
  if (keys == nullptr) return false;
  const auto former = keys->submessage_tokens_of(remote);
  const auto is_ready = core_.keyring.set_endpoint_tokens(local, remote, message.data, protection);
  if (former && keys->submessage_tokens_of(remote) != former)
    note_revised(core_, peer, local, remote.entity);
  if (!is_ready) core_.raise(is_ready.error(), peer, EventOrigin::its_keys);
  return is_ready && *is_ready;
}

bool CryptoTokenExchange::register_pair(const EntityId& local, const Guid& remote,
                                        bool is_relay_only) {
  auto registered = core_.keyring.register_pair(local, remote, is_relay_only);
  if (!registered) {
    const auto* attributes = core_.keyring.attributes(local);
    const bool is_secure = attributes != nullptr && attributes->topic.is_discovery_protected;
    core_.raise(registered.error(), remote, core_.origin_of_announcement(remote, is_secure));
    return false;
  }
  auto* peer = core_.find(remote.prefix);
  auto* association = peer == nullptr ? nullptr : peer->state.association();
  if (!registered->is_new || association == nullptr) return registered->is_ready;
  if (may_send(*association) && association->waiting.empty())
    send_endpoint_tokens(*peer, local, remote, std::move(registered->tokens));
  else if (!registered->tokens.empty())
    add_waiting(*association, local, remote, spi::KeyStage::in_use);
  if (is_revising_ && is_trusted(*peer)) {
    add_waiting(*association, local, remote, spi::KeyStage::revised);
    send_waiting(*peer);
  }
  bool is_ready = registered->is_ready;
  const bool any = apply_early_tokens(*peer, local, remote, is_ready);
  // The remote endpoint may have sent its keys before this pair dropped them or was suspended.
  const bool may_be_lost =
      !any && (association->has_revised || core_.keyring.keys_for(local, remote).may_be_dropped);
  if (registered->are_keys_doubtful || (!is_ready && may_be_lost)) request_tokens(local, remote);
  return is_ready;
}

}  // namespace ddssec::rtps
