#include <algorithm>
#include <limits>
#include <utility>

#include "plugins/cryptography/builtin_names.hpp"
#include "plugins/cryptography/data_piece.hpp"
#include "plugins/cryptography/kept_tokens.hpp"
#include "plugins/cryptography/message.hpp"
#include "plugins/cryptography/token_destination.hpp"
#include "plugins/cryptography/transform.hpp"

namespace ddssec::cryptography {
namespace {

// The content between prefix and postfix: INFO_SRC, if there is a source, and `body`.
struct GroupRequest {
  Frame frame;
  BytesView source;  // version, vendor and prefix of an RTPS header
  BytesView body;
  // Position in `body` of a submessage with length "to the end", which must be replaced by the
  // real length.
  std::optional<std::size_t> open_length;
  std::size_t receivers;

  std::size_t head_size() const { return source.empty() ? 0 : kInfoSourceSize; }
  std::size_t size() const { return head_size() + body.size(); }
};

std::size_t encoded_size(const GroupRequest& request, bool encrypts) {
  const auto content =
      encrypts ? kSubmessageHeaderSize + 4 + padded(request.size()) : request.size();
  return kSubmessageHeaderSize + kCryptoHeaderSize + content + kSubmessageHeaderSize + kFooterSize +
         kReceiverMacSize * request.receivers;
}

// Writes the real length of the submessage whose header is at `position`; it ends with `content`.
void close_length(MutableBytes content, std::size_t position) {
  const auto length = content.size() - position - kSubmessageHeaderSize;
  const bool little = (content[position + 1] & 1) != 0;
  content[position + (little ? 2 : 3)] = static_cast<std::uint8_t>(length);
  content[position + (little ? 3 : 2)] = static_cast<std::uint8_t>(length >> 8);
}

// Writes INFO_SRC, which binds the RTPS header to the protected content (DDS-Security 1.2,
// clause 10.5.3.3.4.5).
void info_source(UncheckedWriter& octets, BytesView source) {
  octets.submessage_header(submessage_id::kInfoSource, kInfoSourceSize - kSubmessageHeaderSize);
  octets.u32(0);
  octets.put(source);
}

// Writes the protected octets to `place`. They come directly from the input if nothing is inserted
// before or into it. Otherwise they are assembled at `place` and encrypted there.
bool protect(const GroupRequest& request, const SendKey& key, const SendKey::Reservation& reserved,
             std::uint8_t* place, TagOut tag) {
  const auto& session = reserved.session->key;
  const bool encrypts = key.traits().encrypts;
  if (encrypts && request.source.empty() && !request.open_length)
    return session.seal({reserved.iv, {}, request.body, place, tag});
  const MutableBytes content(place, request.size());
  UncheckedWriter octets(content);
  if (!request.source.empty()) info_source(octets, request.source);
  octets.put(request.body);
  if (request.open_length) close_length(content, request.head_size() + *request.open_length);
  return encrypts ? session.seal({reserved.iv, {}, content, place, tag})
                  : session.mac(reserved.iv, content, tag);
}

// Writes the MAC of each receiver and returns their number. `receiver(i)` returns the ReceiverKey
// of receiver i as Result. A host lists receivers before this call, and one of them may have left
// meanwhile. The others must still get the message. If no receiver is left, returns the error of
// the last one.
template <class Receiver>
Result<std::size_t> receiver_macs(UncheckedWriter& octets, std::size_t receivers,
                                  const SendKey& key, const SendKey::Reservation& reserved,
                                  TagOut common_mac, Receiver&& receiver) {
  std::size_t written = 0;
  for (std::size_t i = 0; i < receivers; ++i) {
    const auto found = receiver(i);
    const bool is_last = i + 1 == receivers && written == 0;
    if (!found && found.error().code() == Code::crypto_handle_unknown && !is_last) continue;
    DDSSEC_ASSIGN_OR_RETURN(auto* const receiver_key, found);
    octets.put(receiver_key->id().view());
    DDSSEC_RETURN_IF_ERROR(
        receiver_key->mac(key, reserved, common_mac, TagOut(octets.skip(kTagSize), kTagSize)));
    ++written;
  }
  return written;
}

// Encodes a group. `receiver(i)` returns the ReceiverKey of receiver i as Result.
template <class Receiver>
Result<std::size_t> encode_group(const GroupRequest& request, SendKey& key, MutableBytes out,
                                 Receiver&& receiver) {
  const bool encrypts = key.traits().encrypts;
  if (out.size() < encoded_size(request, encrypts)) return fail(Code::length_out_of_range);
  DDSSEC_ASSIGN_OR_RETURN(const auto reserved, key.reserve(request.size()));
  UncheckedWriter octets(out);
  octets.submessage_header(request.frame.prefix, kCryptoHeaderSize, request.frame.prefix_flags);
  octets.crypto_header(key.material().kind, key.material().sender_key_id, reserved.iv);
  if (encrypts) {
    octets.submessage_header(submessage_id::kSecBody, 4 + padded(request.size()));
    octets.u32(static_cast<std::uint32_t>(request.size()));
  }
  auto* const content = octets.skip(request.size());
  if (encrypts) octets.zeros(padded(request.size()) - request.size());
  UncheckedWriter header(out.subspan(octets.written()));
  octets.skip(kSubmessageHeaderSize);
  const TagOut common_mac(octets.skip(kTagSize), kTagSize);
  if (!protect(request, key, reserved, content, common_mac)) return fail(Code::internal);
  UncheckedWriter count(out.subspan(octets.written()));
  octets.skip(sizeof(std::uint32_t));
  DDSSEC_ASSIGN_OR_RETURN(const auto macs, receiver_macs(octets, request.receivers, key, reserved,
                                                         common_mac, receiver));
  header.submessage_header(request.frame.postfix, kFooterSize + kReceiverMacSize * macs);
  count.u32(static_cast<std::uint32_t>(macs));
  return octets.written();
}

// Checks that `plain` is one submessage of whole words. Returns its position if its length must be
// filled in.
Result<std::optional<std::size_t>> check_submessage(BytesView plain) {
  if (plain.size() < kSubmessageHeaderSize || plain.size() % 4 != 0 ||
      plain.size() > kMaxSubmessageContent)
    return fail(Code::plaintext_malformed);
  const auto header = read_submessage_header(plain);
  if (header.length == plain.size() - kSubmessageHeaderSize) return std::nullopt;
  if (header.length != 0) return fail(Code::plaintext_malformed);
  return std::optional<std::size_t>(0);
}

// Checks a chain of submessages. Returns the position of the last one if its length must be filled
// in.
Result<std::optional<std::size_t>> check_submessages(BytesView plain) {
  if (plain.size() < kSubmessageHeaderSize || plain.size() % 4 != 0)
    return fail(Code::plaintext_malformed);
  std::size_t position = 0;
  while (position < plain.size()) {
    const auto header = read_submessage_header(plain.subspan(position));
    const auto left = plain.size() - position - kSubmessageHeaderSize;
    // Only INFO_TS and PAD can be empty; for others, 0 means "to the end" (RTPS 9.4.5.1.3).
    const bool may_be_empty = header.id == submessage_id::kInfoTimestamp || header.id == 0x01;
    if (header.length == 0 && !may_be_empty && left != 0) {
      if (left > kMaxSubmessageContent) return fail(Code::plaintext_malformed);
      return std::optional(position);
    }
    if (header.length > left || header.length % 4 != 0) return fail(Code::plaintext_malformed);
    position += kSubmessageHeaderSize + header.length;
  }
  return std::nullopt;
}

Status check_receivers(spi::ProtectionKind kind, std::size_t count) {
  if (is_origin_authenticated(kind) && (count == 0 || count > kMaxReceivers))
    return fail(Code::receiver_count);
  return {};
}

// Raises an event if the peer of the pair would get key tokens that are not for it. The host sends
// them only if the peer asked for them.
Status check_volatile(const CryptographyState& state, ParticipantPair& pair, BytesView submessage) {
  // Such a host has one volatile writer for each peer, which can send to no other one. Its
  // fragments may be too small to name the destination.
  if (state.host_checks_sources) {
    note_fragment(submessage, pair.fragmented_tokens);
    return {};
  }
  auto status = check_token_destination(submessage, pair.peer_prefix, pair.fragmented_tokens);
  if (!status) state.report(status.error(), pair.peer_prefix);
  return status;
}

// Encodes a submessage of a volatile endpoint, which goes to one participant under the key of the
// pair.
template <class Remote>
Result<std::size_t> encode_volatile(const CryptographyState& state,
                                    const LocalEndpointCrypto& sender,
                                    std::span<const Remote> receivers, GroupRequest request,
                                    MutableBytes out) {
  if (receivers.size() != 1) return fail(Code::receiver_count);
  DDSSEC_ASSIGN_OR_RETURN(const auto* const remote,
                          state.remote_endpoint(receivers.front(), remote_kind(Remote{})));
  auto* const pair = remote->participant.pair(sender.participant.handle());
  if (&remote->local != &sender || pair == nullptr) return fail(Code::crypto_not_matched);
  if (sender.kind() == EntityKind::local_reader)
    pair->has_reader_spoken.store(true, std::memory_order_release);
  DDSSEC_RETURN_IF_ERROR(check_volatile(state, *pair, request.body));
  if (const auto acknowledged = read_acknowledgment(request.body);
      acknowledged && !state.host_checks_sources)
    state.ledger.acknowledged(pair->number, acknowledged->next, state.services.clock.monotonic());
  note_own_tokens(state, sender, *pair, request.body);
  request.receivers = 0;
  return encode_group(request, *pair->key_exchange_send, out,
                      [](std::size_t) -> Result<ReceiverKey*> { return fail(Code::internal); });
}

// Records in the peer's discovery state which samples the host has acknowledged. `find` returns the
// peer, or nullptr.
template <class F>
void note_acknowledged(BytesView submessage, F&& find) {
  const auto acknowledged = read_acknowledgment(submessage);
  const auto* const topic = acknowledged ? discovery_topic_of(acknowledged->writer) : nullptr;
  const RemoteParticipantCrypto* const peer = topic == nullptr ? nullptr : find();
  if (peer != nullptr) peer->discovery.announced.acknowledged(*topic, acknowledged->next);
}

// As note_acknowledged above, for a submessage that goes to these writers of one participant.
template <class Remote>
void note_acknowledged(const CryptographyState& state, std::span<const Remote> receivers,
                       BytesView submessage) {
  if (state.host_checks_sources || receivers.empty()) return;
  note_acknowledged(submessage, [&]() -> const RemoteParticipantCrypto* {
    const auto remote = state.remote_endpoint(receivers.front(), remote_kind(Remote{}));
    return remote ? &(*remote)->participant : nullptr;
  });
}

// As note_acknowledged above, for the submessages inside a message, whose receivers INFO_DST names.
void note_acknowledged(const CryptographyState& state, const LocalParticipantCrypto& sender,
                       BytesView message) {
  GuidPrefix to;
  for (auto rest = message.subspan(kRtpsHeaderSize); !rest.empty();) {
    const auto size = size_of_first_submessage(rest);
    if (!size) return;
    if (rest[0] == submessage_id::kInfoDestination &&
        *size >= kSubmessageHeaderSize + GuidPrefix::size)
      to = GuidPrefix::from(rest.subspan(kSubmessageHeaderSize, GuidPrefix::size));
    note_acknowledged(rest.first(*size),
                      [&] { return find_peer(state, sender, to).value_or(nullptr); });
    rest = rest.subspan(*size);
  }
}

// Returns the key of the reader `sender` that all of these writers share. One of them may have left
// since the host listed them. Errors: receiver_count for no writer, or for writers of several
// participants; crypto_not_matched; crypto_handle_unknown if all have left.
template <class Remote>
Result<SendKey*> peer_key(const CryptographyState& state, const LocalEndpointCrypto& sender,
                          std::span<const Remote> receivers) {
  const PeerKey* common = nullptr;
  for (std::size_t i = 0; i < receivers.size(); ++i) {
    const auto found = state.remote_endpoint(receivers[i], remote_kind(Remote{}));
    const bool is_last = i + 1 == receivers.size() && common == nullptr;
    if (!found && found.error().code() == Code::crypto_handle_unknown && !is_last) continue;
    DDSSEC_RETURN_IF_ERROR(found);
    const auto& remote = **found;
    if (&remote.local != &sender) return fail(Code::crypto_not_matched);
    if (common != nullptr && remote.peer_key.get() != common)
      return fail(Code::receiver_count, {.expected = "writers of one participant"});
    common = remote.peer_key.get();
  }
  if (common == nullptr) return fail(Code::receiver_count);
  return common->key.read();
}

// Returns the key of the endpoint `sender` for these receivers.
template <class Remote>
Result<SendKey*> key_towards(const CryptographyState& state, const LocalEndpointCrypto& sender,
                             std::span<const Remote> receivers) {
  return sender.has_peer_keys() ? peer_key(state, sender, receivers)
                                : Result<SendKey*>(sender.submessage_key.read());
}

template <class Local, class Remote>
Result<std::size_t> encode_submessage(const CryptographyState& state, Local handle,
                                      std::span<const Remote> receivers, BytesView plain,
                                      MutableBytes out) {
  const ReadGuard guard;
  DDSSEC_ASSIGN_OR_RETURN(const auto local_endpoint,
                          state.local_endpoint(handle, local_kind(handle)));
  const auto& sender = *local_endpoint;
  DDSSEC_RETURN_IF_ERROR(check_not_cut_off(sender.participant));
  if (!is_protected(sender.submessage)) return fail(Code::not_protected);
  DDSSEC_ASSIGN_OR_RETURN(auto submessage, check_submessage(plain));
  GroupRequest request{kSubmessageFrame, {}, plain, std::move(submessage), 0};
  if (sender.is_volatile) return encode_volatile(state, sender, receivers, request, out);
  note_acknowledged(state, receivers, plain);
  DDSSEC_RETURN_IF_ERROR(check_receivers(sender.submessage, receivers.size()));
  if (is_origin_authenticated(sender.submessage)) request.receivers = receivers.size();
  DDSSEC_ASSIGN_OR_RETURN(const auto found_key, key_towards(state, sender, receivers));
  auto& key = *found_key;
  return encode_group(request, key, out, [&](std::size_t i) -> Result<ReceiverKey*> {
    DDSSEC_ASSIGN_OR_RETURN(const auto remote_endpoint,
                            state.remote_endpoint(receivers[i], remote_kind(Remote{})));
    const auto& remote = *remote_endpoint;
    if (&remote.local != &sender) return fail(Code::crypto_not_matched);
    return remote.receiver_key.get();
  });
}

// Returns the content of the RTPS message between its header and SRTPS_POSTFIX.
Result<GroupRequest> message_request(BytesView plain, Frame frame, bool encrypts) {
  if (plain.size() < kRtpsHeaderSize || as_text(plain.first(4)) != "RTPS")
    return fail(Code::plaintext_malformed);
  const auto body = plain.subspan(kRtpsHeaderSize);
  GroupRequest request{frame, plain.subspan(4, 16), body, std::nullopt, 0};
  if (!encrypts) {
    DDSSEC_ASSIGN_OR_RETURN(request.open_length, check_submessages(body));
  } else if (body.empty() || 4 + padded(request.size()) > kMaxSubmessageContent)
    return fail(Code::plaintext_malformed);
  return request;
}

// Writes the unchanged header, then the group.
template <class Receiver>
Result<std::size_t> seal_message(BytesView plain, const GroupRequest& request, SendKey& key,
                                 MutableBytes out, Receiver&& receiver) {
  if (out.size() < kRtpsHeaderSize) return fail(Code::length_out_of_range);
  DDSSEC_ASSIGN_OR_RETURN(const auto written,
                          encode_group(request, key, out.subspan(kRtpsHeaderSize), receiver));
  UncheckedWriter(out).put(plain.first(kRtpsHeaderSize));
  return kRtpsHeaderSize + written;
}

}  // namespace

Result<std::size_t> seal_message(BytesView plain, Frame frame, SendKey& key, MutableBytes out) {
  DDSSEC_ASSIGN_OR_RETURN(const auto request, message_request(plain, frame, key.traits().encrypts));
  return seal_message(plain, request, key, out,
                      [](std::size_t) -> Result<ReceiverKey*> { return fail(Code::internal); });
}

Result<std::size_t> Transform::encode_serialized_payload(spi::DatawriterCryptoHandle sender,
                                                         BytesView plain, MutableBytes out) {
  const ReadGuard guard;
  DDSSEC_ASSIGN_OR_RETURN(const auto local_endpoint,
                          state_.local_endpoint(sender, EntityKind::local_writer));
  const auto& writer = *local_endpoint;
  DDSSEC_RETURN_IF_ERROR(check_not_cut_off(writer.participant));
  auto* const current = writer.payload_key.read();
  if (current == nullptr) return fail(Code::not_protected);
  auto& key = *current;
  const bool encrypts = key.traits().encrypts;
  const auto size = kCryptoHeaderSize + (encrypts ? 4 : 0) + plain.size() + kFooterSize;
  if (plain.size() > std::numeric_limits<std::uint32_t>::max() || out.size() < size)
    return fail(Code::length_out_of_range);
  DDSSEC_ASSIGN_OR_RETURN(const auto reserved, key.reserve(plain.size()));
  UncheckedWriter octets(out);
  octets.crypto_header(key.material().kind, key.material().sender_key_id, reserved.iv);
  if (encrypts) octets.u32(static_cast<std::uint32_t>(plain.size()));
  auto* const content = octets.skip(plain.size());
  const TagOut tag(octets.skip(kTagSize), kTagSize);
  if (!encrypts) UncheckedWriter({content, plain.size()}).put(plain);
  const bool done = encrypts ? reserved.session->key.seal({reserved.iv, {}, plain, content, tag})
                             : reserved.session->key.mac(reserved.iv, plain, tag);
  if (!done) return fail(Code::internal);
  octets.u32(0);
  return octets.written();
}

Result<std::size_t> Transform::encode_datawriter_submessage(
    spi::DatawriterCryptoHandle sender, std::span<const spi::DatareaderCryptoHandle> receivers,
    BytesView plain, MutableBytes out) {
  return encode_submessage(state_, sender, receivers, plain, out);
}

Result<std::size_t> Transform::encode_datareader_submessage(
    spi::DatareaderCryptoHandle sender, std::span<const spi::DatawriterCryptoHandle> receivers,
    BytesView plain, MutableBytes out) {
  return encode_submessage(state_, sender, receivers, plain, out);
}

Result<std::size_t> Transform::encode_rtps_message(
    spi::ParticipantCryptoHandle sender, std::span<const spi::ParticipantCryptoHandle> receivers,
    BytesView plain, MutableBytes out) {
  const ReadGuard guard;
  DDSSEC_ASSIGN_OR_RETURN(const auto local_participant, state_.local_participant(sender));
  const auto& participant = *local_participant;
  DDSSEC_RETURN_IF_ERROR(check_not_cut_off(participant));
  auto* const key = participant.key.read();
  if (key == nullptr) return fail(Code::not_protected);
  DDSSEC_RETURN_IF_ERROR(check_receivers(participant.rtps, receivers.size()));
  DDSSEC_ASSIGN_OR_RETURN(auto request,
                          message_request(plain, kMessageFrame, key->traits().encrypts));
  if (!state_.host_checks_sources) note_acknowledged(state_, participant, plain);
  if (is_origin_authenticated(participant.rtps)) request.receivers = receivers.size();
  return seal_message(plain, request, *key, out, [&](std::size_t i) -> Result<ReceiverKey*> {
    DDSSEC_ASSIGN_OR_RETURN(const auto remote_participant, state_.remote_participant(receivers[i]));
    const auto* const pair = remote_participant->pair(sender.value);
    if (pair == nullptr) return fail(Code::crypto_not_matched);
    return pair->receiver_key.get();
  });
}

}  // namespace ddssec::cryptography
