// Security, the part that hands keys out and takes them in, by the volatile secure endpoints.
#include <algorithm>

#include "rtps/security/security.hpp"

namespace ddssec::rtps {
namespace {

Qos volatile_qos() {
  auto qos = default_writer_qos();
  qos.history.kind = HistoryKind::keep_all;
  return qos;
}

}  // namespace

void Security::open_volatile(Peer& peer, MonotonicTime now) {
  const auto prefix = peer.data.guid.prefix;
  const Guid writer{prefix, kVolatileMessageWriter}, reader{prefix, kVolatileMessageReader};
  peer.volatile_writer = std::make_unique<StatefulWriter>(
      Guid{own_->guid().prefix, kVolatileMessageWriter}, volatile_qos(), sender_, &timers_);
  peer.volatile_reader = std::make_unique<StatefulReader>(
      Guid{own_->guid().prefix, kVolatileMessageReader}, true, sender_,
      [this, prefix](Change& change) { return on_volatile(prefix, change); }, &timers_);
  peer.volatile_reader->limit(kVolatileLimits);
  peer.volatile_writer->match({reader, true, false, peer.metatraffic}, now);
  peer.volatile_reader->match({writer, true, peer.metatraffic}, now);
  auto tokens = keyring_.participant_tokens(prefix);
  if (!tokens) {
    refuse(peer);
    return;
  }
  send_tokens(peer, message_class::kParticipantTokens, {}, {}, std::move(*tokens));
  if (revision_) send_revised(peer);
}

StatefulWriter* Security::volatile_writer(const GuidPrefix& prefix) {
  auto* peer = find(prefix);
  return peer == nullptr ? nullptr : peer->volatile_writer.get();
}

StatefulReader* Security::volatile_reader(const GuidPrefix& prefix) {
  auto* peer = find(prefix);
  return peer == nullptr ? nullptr : peer->volatile_reader.get();
}

void Security::send_tokens(Peer& peer, std::string_view message_class, const Guid& from,
                           const Guid& to, std::vector<spi::Token> tokens) {
  if (tokens.empty() || !peer.volatile_writer) return;
  GenericMessage message;
  message.destination_endpoint = to;
  message.source_endpoint = from;
  message.message_class = message_class;
  message.data = std::move(tokens);
  send_volatile(peer, std::move(message));
}

// Nobody else can acknowledge it, and no acknowledgement was ever for it.
void Security::ask_over_volatile(Peer& peer) {
  GenericMessage message;
  message.message_class = message_class::kQuestion;
  if (peer.volatile_writer) send_volatile(peer, std::move(message));
}

void Security::send_volatile(Peer& peer, GenericMessage message) {
  message.identity = {{own_->guid().prefix, kVolatileMessageWriter}, ++volatile_number_};
  message.destination_participant = peer.data.guid;
  Change change;
  auto octets = write_generic_message(message);
  change.payload = Payload::copy_of(octets);
  change.payload.wipe_at_end();
  wipe(octets);
  peer.volatile_writer->write(std::move(change), now_);
}

void Security::send_endpoint_tokens(Peer& peer, const EntityId& local, const Guid& remote,
                                    std::vector<spi::Token> tokens) {
  send_tokens(
      peer, is_writer(local) ? message_class::kDatawriterTokens : message_class::kDatareaderTokens,
      {own_->guid().prefix, local}, remote, std::move(tokens));
}

// It was protected by the key of this pair of participants; what is in it is checked all the same.
bool Security::on_volatile(const GuidPrefix& prefix, const Change& change) {
  auto* peer = find(prefix);
  if (peer == nullptr || !peer->established) return true;
  const auto size = change.payload.size();
  if (size > kMostTokenOctets) {
    events_.raise(
        Event(Error(Code::length_out_of_range,
                    {.document = "key tokens",
                     .expected = "at most " + std::to_string(kMostTokenOctets) + " octets",
                     .found = std::to_string(size)}),
              {}, peer->data.guid.to_string()));
    return true;
  }
  auto message = read_generic_message(change.payload.view());
  if (!message) return true;
  // Fast DDS names its stateless writer as the source.
  if (message->identity.source.prefix != prefix || message->destination_participant != own_->guid())
    return true;
  if (message->message_class == message_class::kParticipantTokens)
    on_participant_tokens(*peer, *message);
  else if (message->message_class == message_class::kDatawriterTokens ||
           message->message_class == message_class::kDatareaderTokens)
    on_endpoint_tokens(*peer, std::move(*message), size);
  return true;
}

void Security::on_participant_tokens(Peer& peer, const GenericMessage& message) {
  const auto prefix = peer.data.guid.prefix;
  const auto status = keyring_.set_participant_tokens(prefix, message.data);
  if (!status) {
    events_.raise(Event(status.error(), {}, peer.data.guid.to_string()));
    return;
  }
  // It can read ours by now: what it could not read before is offered again at once.
  if (peer.volatile_writer) peer.volatile_writer->ask_for_acknowledgments();
  note_authenticated(peer);
}

void Security::note_authenticated(Peer& peer) {
  if (std::exchange(peer.authenticated, true)) return;
  ++counters_.authenticated;
  host_.on_authenticated(GuidPrefix(peer.data.guid.prefix));
}

void Security::note_key_exchange(const GuidPrefix& prefix) {
  auto* peer = find(prefix);
  if (peer == nullptr || std::exchange(peer->exchanges_keys, true)) return;
  look_after(*peer);
}

bool Security::needs_no_tokens(const Peer& peer) const {
  return peer.established && !peer.authenticated && peer.exchanges_keys &&
         !own_->attributes().is_rtps_protected();
}

// For endpoints that we do not know yet they are kept: discovery and keys come in any order.
void Security::on_endpoint_tokens(Peer& peer, GenericMessage message, std::size_t octets) {
  const auto& local = message.destination_endpoint;
  const auto& remote = message.source_endpoint;
  const bool to_reader = message.message_class == message_class::kDatawriterTokens;
  const bool fits = local.prefix == own_->guid().prefix && remote.prefix == peer.data.guid.prefix &&
                    is_reader(local.entity) == to_reader && is_writer(remote.entity) == to_reader;
  if (!fits) return;
  if (keyring_.is_introduced(local.entity, remote)) return apply_tokens(peer, message);
  const auto of_pair = [&](const auto& held) {
    return held.message.destination_endpoint == local && held.message.source_endpoint == remote;
  };
  if (std::ranges::count_if(peer.early, of_pair) >= std::ptrdiff_t{kMostEarlyOfPair})
    drop_early(peer, std::ranges::find_if(peer.early, of_pair));
  while (peer.early.size() >= kMostEarlyTokens || peer.early_octets + octets > kMostEarlyOctets)
    drop_early(peer, peer.early.begin());
  const Guid source = remote;
  peer.early.push_back({std::move(message), octets});
  peer.early_octets += octets;
  host_.on_early_keys(source);
}

void Security::drop_early(Peer& peer, std::vector<EarlyTokens>::iterator at) {
  peer.early_octets -= at->octets;
  peer.early.erase(at);
}

void Security::apply_tokens(Peer& peer, const GenericMessage& message) {
  const auto local = message.destination_endpoint.entity;
  const auto remote = message.source_endpoint;
  const auto ready = keyring_.set_endpoint_tokens(local, remote, message.data);
  if (!ready) {
    events_.raise(Event(ready.error(), {}, peer.data.guid.to_string()));
  } else if (*ready) {
    host_.on_keys(local, remote);
  }
}

bool Security::introduce(const EntityId& local, const Guid& remote, bool relay_only) {
  auto introduced = keyring_.introduce(local, remote, relay_only);
  if (!introduced) {
    events_.raise(Event(introduced.error(), {}, remote.to_string()));
    return false;
  }
  auto* peer = find(remote.prefix);
  if (!introduced->is_new || peer == nullptr) return introduced->ready;
  send_endpoint_tokens(*peer, local, remote, std::move(introduced->tokens));
  if (revision_) send_revised(*peer, local, remote);
  apply_early_tokens(*peer, local, remote, introduced->ready);
  return introduced->ready;
}

void Security::apply_early_tokens(Peer& peer, const EntityId& local, const Guid& remote,
                                  bool& ready) {
  std::erase_if(peer.early, [&](const auto& held) {
    const auto& message = held.message;
    if (message.destination_endpoint.entity != local || message.source_endpoint != remote)
      return false;
    const auto set = keyring_.set_endpoint_tokens(local, remote, message.data);
    if (!set) events_.raise(Event(set.error(), {}, peer.data.guid.to_string()));
    ready = ready || (set && *set);
    peer.early_octets -= held.octets;
    return true;
  });
}

}  // namespace ddssec::rtps
