#include "plugins/cryptography/kept_tokens.hpp"

#include <algorithm>
#include <mutex>
#include <optional>

#include "base/rollback.hpp"
#include "plugins/cryptography/builtin_checks.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "plugins/cryptography/key_exchange.hpp"
#include "plugins/cryptography/key_material.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::cryptography {
namespace {

// True if the host has matched all builtin endpoints that share keys between the local participant
// and the sender's. False while another thread changes them: the message comes again.
bool are_builtin_matched(const CryptographyState& state, const RemoteEndpointCrypto& sender) {
  const std::unique_lock lock(state.mutex, std::try_to_lock);
  if (!lock.owns_lock()) return false;
  const auto& participant = sender.local.participant;
  const auto is_matched = [&](std::int64_t handle, EntityKind local, EntityKind remote) {
    const auto endpoint = state.registry.find<LocalEndpointCrypto>(handle, local);
    if (!endpoint || !(*endpoint)->is_builtin || (*endpoint)->is_volatile) return true;
    return std::ranges::any_of((*endpoint)->matched, [&](std::int64_t matched) {
      const auto found = state.registry.find<RemoteEndpointCrypto>(matched, remote);
      return found && &(*found)->participant == &sender.participant;
    });
  };
  return std::ranges::all_of(participant.endpoints, [&](std::int64_t handle) {
    return is_matched(handle, EntityKind::local_writer, EntityKind::remote_reader) &&
           is_matched(handle, EntityKind::local_reader, EntityKind::remote_writer);
  });
}

// True if any local endpoint accepts such tokens. A host never uses a reader's tokens if the
// writer's submessages are not protected, and would store them without need. True while another
// thread changes the endpoints.
bool may_be_used(const CryptographyState& state, const RemoteEndpointCrypto& sender,
                 const TokenMessage& message) {
  if (message.remote.entity == kEntityIdParticipant) return true;
  const std::unique_lock lock(state.mutex, std::try_to_lock);
  if (!lock.owns_lock()) return true;
  const bool for_builtin = rtps::is_builtin(message.remote.entity);
  const auto kind = message.is_of_reader ? EntityKind::local_writer : EntityKind::local_reader;
  return std::ranges::any_of(sender.local.participant.endpoints, [&](std::int64_t handle) {
    const auto found = state.registry.find<LocalEndpointCrypto>(handle, kind);
    if (!found) return false;
    const auto& endpoint = **found;
    // Another vendor's access control does not report which endpoints are builtin.
    if (!for_builtin && endpoint.is_builtin) return false;
    return endpoint.has_tokens() && (!message.is_of_reader || is_protected(endpoint.submessage));
  });
}

// The decision about a token message, and the error to report.
struct Judgement {
  TokenDecision passage;
  std::optional<Error> reported = {};
};

Result<Judgement> judge(const CryptographyState& state, const RemoteEndpointCrypto& sender,
                        const ParticipantPair& pair, const TokenMessage& message) {
  using Kind = TokenDecision::Kind;
  if (auto status = check_usable(message); !status)
    return Judgement{{Kind::hidden}, std::move(status).error()};
  // The ledger identifies sessions by the pair. Messages for another pair come by that pair's own
  // channel.
  if (pair.own_prefix && message.local.prefix != *pair.own_prefix)
    return Judgement{{Kind::hidden},
                     Error(Code::token_source_mismatch, {.document = "a key token message",
                                                         .field = "destination_participant_guid",
                                                         .expected = pair.own_prefix->to_string(),
                                                         .found = message.local.to_string()})};
  if (!may_be_used(state, sender, message)) return Judgement{{Kind::hidden}};
  const bool are_matched =
      rtps::is_builtin(message.remote.entity) && are_builtin_matched(state, sender);
  auto noted = state.ledger.note(message, {pair.number, pair.peer_prefix.has_value()}, are_matched,
                                 state.services.clock.monotonic());
  // A message that is not accepted would delay all that follow, including those of honest
  // endpoints.
  if (!noted) return Judgement{{Kind::hidden}, std::move(noted).error()};
  const auto passage = *noted;
  // The host logs it. No event is raised, because honest peers that discovered each other again
  // after a loss send such messages.
  if (passage.kind == Kind::later) return fail(Code::crypto_tokens_repeated);
  if (passage.kind != Kind::repeated) return Judgement{passage};
  return Judgement{
      passage, Error(Code::crypto_tokens_repeated, {.document = "a key token message",
                                                    .found = message.remote.to_string(),
                                                    .note = "for " + message.local.to_string()})};
}

// Gives tokens from the ledger to a match that waits for them. An error is reported as a separate
// event.
void hand_over(CryptographyState& state, const TokenMessage& message,
               const TokenDecision& passage) {
  spi::Token token = message.tokens.front();
  auto& value = token.binary_properties.front().value;
  wipe(value);
  std::ranges::copy(passage.ticket.octets, value.begin());
  const auto [exchange, local, remote] = passage.user;
  KeyExchange keys(state);
  if (message.is_of_reader)
    (void)keys.set_remote_datareader_crypto_tokens({local}, {remote}, {&token, 1});
  else
    (void)keys.set_remote_datawriter_crypto_tokens({local}, {remote}, {&token, 1});
}

// True if the local endpoint needs the peer's tokens. A reader has tokens only if it needs those
// of writers. A writer needs those of readers if it protects submessages; the key for these comes
// first in its tokens. True while another thread changes the endpoints.
bool needs_tokens(const CryptographyState& state, const LocalParticipantCrypto& participant,
                  const TokenMessage& own) {
  if (own.is_of_reader) return true;
  if (own.tokens.empty()) return false;
  const auto material = read_crypto_token(own.tokens.front());
  if (!material) return false;
  const std::unique_lock lock(state.mutex, std::try_to_lock);
  if (!lock.owns_lock()) return true;
  return std::ranges::any_of(participant.endpoints, [&](std::int64_t handle) {
    const auto found = state.registry.find<LocalEndpointCrypto>(handle, EntityKind::local_writer);
    const auto* const key = found ? (*found)->submessage_key.read() : nullptr;
    return key != nullptr && key->material().sender_key_id == material->sender_key_id;
  });
}

}  // namespace

Status keep_tokens(CryptographyState& state, const RemoteEndpointCrypto& sender,
                   const ParticipantPair& pair, MutableBytes submessage) {
  if (!writer_of_data(submessage)) return {};
  if (!pair.has_reader_spoken.load(std::memory_order_acquire))
    return fail(Code::crypto_tokens_early);
  DDSSEC_ASSIGN_OR_RETURN(const auto piece, read_data_piece(submessage));
  DDSSEC_ASSIGN_OR_RETURN(auto message, read_token_message(piece));
  if (!message) return {};
  const Rollback wipe_copy([&] { wipe_tokens(message->tokens); });
  DDSSEC_ASSIGN_OR_RETURN(const auto judged, judge(state, sender, pair, *message));
  const auto& [passage, reported] = judged;
  const auto payload = submessage.subspan(
      static_cast<std::size_t>(piece.payload.data() - submessage.data()), piece.payload.size());
  write_ticket(passage.ticket, *message, piece, payload);
  if (passage.kind != TokenDecision::Kind::ticket) payload[message->class_at] = '-';
  if (passage.kind == TokenDecision::Kind::awaited) hand_over(state, *message, passage);
  if (reported) state.report(*reported, pair.peer_prefix);
  return {};
}

void note_own_tokens(const CryptographyState& state, const LocalEndpointCrypto& sender,
                     const ParticipantPair& pair, BytesView submessage) {
  if (state.host_checks_sources || sender.kind() != EntityKind::local_writer ||
      !pair.peer_uses_ddssec() || !writer_of_data(submessage))
    return;
  const auto piece = read_data_piece(submessage);
  if (!piece) return;
  auto message = read_token_message(*piece);
  if (!message || !*message) return;
  auto& own = **message;
  const Rollback wipe_copy([&] { wipe_tokens(own.tokens); });
  if (own.remote.entity == kEntityIdParticipant) return;
  if (!needs_tokens(state, sender.participant, own)) return;
  state.ledger.await(pair.number, {.remote = own.local, .local = own.remote},
                     state.services.clock.monotonic());
}

}  // namespace ddssec::cryptography
