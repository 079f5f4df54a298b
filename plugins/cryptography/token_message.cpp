#include "plugins/cryptography/token_message.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "base/hash.hpp"
#include "plugins/cryptography/key_material.hpp"
#include "plugins/spi/message_class.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::cryptography {
namespace {

constexpr std::string_view kTokenMessage = "a key token message";
constexpr std::size_t kEncapsulationSize = 4;

Result<Guid> read_guid(Reader& in) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, in.read_bytes(Guid::size));
  return Guid::from(octets);
}

// Returns the number of octets of the class id, and of the name and value of each property.
std::size_t octets_with_names(const spi::Token& token) {
  auto octets = token.class_id.size();
  for (const auto& one : token.properties) octets += one.name.size() + one.value.size();
  for (const auto& one : token.binary_properties) octets += one.name.size() + one.value.size();
  return octets;
}

// True for a writer and a reader of one secure builtin topic (DDS-Security 1.2, clause 7.5.8). The
// sender chooses the bits of an entity id that mark it as builtin, and the host matches no other
// builtin endpoints by itself.
bool are_builtin_pair(const EntityId& writer, const EntityId& reader) {
  using namespace rtps;
  constexpr std::array kPairs = {
      std::pair(kPublicationsSecureWriter, kPublicationsSecureReader),
      std::pair(kSubscriptionsSecureWriter, kSubscriptionsSecureReader),
      std::pair(kParticipantMessageSecureWriter, kParticipantMessageSecureReader),
      std::pair(kParticipantsSecureWriter, kParticipantsSecureReader)};
  return std::ranges::find(kPairs, std::pair(writer, reader)) != kPairs.end();
}

// True for two endpoints, or two participants, for which the host can use tokens at all.
bool are_two_of_a_kind(const TokenMessage& message) {
  const auto &remote = message.remote.entity, &local = message.local.entity;
  if (remote == kEntityIdParticipant) return local == kEntityIdParticipant;
  const auto &writer = message.is_of_reader ? local : remote,
             &reader = message.is_of_reader ? remote : local;
  if (!rtps::is_writer(writer) || !rtps::is_reader(reader)) return false;
  const bool is_builtin = rtps::is_builtin(remote) || rtps::is_builtin(local);
  return !is_builtin || are_builtin_pair(writer, reader);
}

Result<std::vector<spi::Token>> read_tokens(Reader& in) {
  constexpr std::size_t kMinToken = 12;
  DDSSEC_ASSIGN_OR_RETURN(const auto count, in.read_count(kMinToken));
  if (count > spi::kMaxTokensPerMessage) return fail(Code::length_out_of_range);
  std::vector<spi::Token> tokens;
  std::size_t octets = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    DDSSEC_ASSIGN_OR_RETURN(auto token, spi::read_token(in));
    tokens.push_back(std::move(token));
    octets += octets_with_names(tokens.back());
  }
  if (octets > kMaxTokenOctets) return fail(Code::length_out_of_range);
  return tokens;
}

// Returns the values of the binary properties of `tokens`, which read_tokens has read from the same
// octets at `tokens_at`. An error is therefore impossible, but after one a caller must still let no
// key pass.
Result<std::vector<BytesView>> find_binary_values(Reader& in, std::size_t tokens_at,
                                                  std::span<const spi::Token> tokens) {
  std::vector<BytesView> values;
  DDSSEC_RETURN_IF_ERROR(in.skip(tokens_at));
  DDSSEC_RETURN_IF_ERROR(in.read_count(1));
  for (const auto& token : tokens) {
    DDSSEC_RETURN_IF_ERROR(in.read_string());
    DDSSEC_RETURN_IF_ERROR(in.read_count(1));
    for (std::size_t i = 0; i < 2 * token.properties.size(); ++i)
      DDSSEC_RETURN_IF_ERROR(in.read_string());
    DDSSEC_RETURN_IF_ERROR(in.read_count(1));
    for (std::size_t i = 0; i < token.binary_properties.size(); ++i) {
      DDSSEC_RETURN_IF_ERROR(in.read_string());
      DDSSEC_ASSIGN_OR_RETURN(const auto value, in.read_octet_sequence());
      values.push_back(value);
    }
  }
  return values;
}

// Reads a ParticipantGenericMessage (DDS-Security 1.2, clause 7.3.22).
Result<std::optional<TokenMessage>> read_generic_message(const DataPiece& piece) {
  // The message's number, and related_message_identity.
  constexpr std::size_t kAfterSource = 8 + 24;
  const bool little = (piece.payload[1] & 1) != 0;
  Reader in(piece.payload.subspan(kEncapsulationSize), little ? Endian::little : Endian::big);
  DDSSEC_ASSIGN_OR_RETURN(const auto source, read_guid(in));
  DDSSEC_RETURN_IF_ERROR(in.skip(kAfterSource));
  DDSSEC_ASSIGN_OR_RETURN(const auto participant, read_guid(in));
  DDSSEC_ASSIGN_OR_RETURN(const auto endpoint, read_guid(in));
  DDSSEC_ASSIGN_OR_RETURN(const auto source_endpoint, read_guid(in));
  const auto class_at = kEncapsulationSize + in.position() + sizeof(std::uint32_t);
  DDSSEC_ASSIGN_OR_RETURN(const auto class_id, in.read_string());
  const bool is_of_reader = class_id == spi::message_class::kDatareaderTokens;
  TokenMessage message{source_endpoint, endpoint, piece.number, is_of_reader, {}, class_at, 0};
  if (class_id == spi::message_class::kParticipantTokens) {
    message.remote = {source.prefix, kEntityIdParticipant};
    message.local = participant;
  } else if (class_id != spi::message_class::kDatawriterTokens && !is_of_reader) {
    return std::nullopt;
  } else if (source_endpoint.prefix != source.prefix ||
             source_endpoint.entity == kEntityIdParticipant) {
    // The token has no owner, or a participant's tokens are presented as those of an endpoint.
    return fail(Code::malformed);
  }
  if (piece.number >= kMaxNumber) return fail(Code::length_out_of_range);
  message.tokens_at = kEncapsulationSize + in.position();
  DDSSEC_ASSIGN_OR_RETURN(message.tokens, read_tokens(in));
  return message;
}

}  // namespace

Result<std::optional<TokenMessage>> read_token_message(const DataPiece& piece) {
  if (!piece.begins_sample) return std::nullopt;
  auto message = read_generic_message(piece);
  if (message) return message;
  return fail(Code::token_source_unreadable,
              {.document = std::string(kTokenMessage), .note = "its tokens cannot be read"});
}

Status check_usable(const TokenMessage& message) {
  if (!are_two_of_a_kind(message))
    return fail(Code::token_source_unreadable,
                {.document = std::string(kTokenMessage),
                 .found = message.remote.to_string() + " for " + message.local.to_string(),
                 .note = "no two such endpoints exchange keys"});
  const bool is_of_participant = message.remote.entity == kEntityIdParticipant;
  const auto most = is_of_participant ? 1 : kMaxTokensPerEndpoint;
  if (message.tokens.empty() || message.tokens.size() > most)
    return fail(Code::crypto_token_count, {.document = std::string(kTokenMessage)});
  for (const auto& token : message.tokens) DDSSEC_RETURN_IF_ERROR(read_crypto_token(token));
  return {};
}

void write_ticket(const Ticket& ticket, const TokenMessage& message, const DataPiece& piece,
                  MutableBytes payload) {
  const bool little = (piece.payload[1] & 1) != 0;
  const auto stream = payload.subspan(kEncapsulationSize);
  const auto tokens_at = message.tokens_at - kEncapsulationSize;
  Reader in(stream, little ? Endian::little : Endian::big);
  const auto values = find_binary_values(in, tokens_at, message.tokens);
  if (!values) return wipe(stream.subspan(tokens_at));
  for (const auto value : *values)
    wipe(stream.subspan(static_cast<std::size_t>(value.data() - stream.data()), value.size()));
  if (values->empty()) return;
  const auto first = static_cast<std::size_t>(values->front().data() - stream.data());
  std::ranges::copy(ticket.octets, stream.subspan(first).begin());
}

}  // namespace ddssec::cryptography
