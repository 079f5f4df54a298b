#include <algorithm>
#include <array>

#include "base/rollback.hpp"
#include "plugins/cryptography/builtin_checks.hpp"
#include "plugins/cryptography/kept_tokens.hpp"
#include "plugins/cryptography/key_owner.hpp"
#include "plugins/cryptography/key_revision.hpp"
#include "plugins/cryptography/message.hpp"
#include "plugins/cryptography/token_destination.hpp"
#include "plugins/cryptography/transform.hpp"

namespace ddssec::cryptography {
namespace {

// Success if the message is protected in the way that its sender's key demands. The key itself was
// checked against the governance.
Status check_header(const ReceiveKey& key, const CryptoHeader& header, bool is_encrypted) {
  if (is_encrypted != key.traits().encrypts)
    return fail(is_encrypted ? Code::encrypted_where_signature_is_due
                             : Code::signed_where_encryption_is_due);
  if (header.kind != key.material().kind) return fail(Code::transform_kind_mismatch);
  if (header.key_id != key.material().sender_key_id) return fail(Code::transform_key_id_mismatch);
  return {};
}

// Writes plain octets to `place` and returns true if the tag is right. Otherwise it writes no
// plain octets.
bool open_content(const ProtectedParts& message, const ExpandedKey& key, std::uint8_t* place) {
  if (message.is_encrypted)
    return key.open(message.header.iv, {}, message.content, place, message.footer.tag());
  if (!key.verify(message.header.iv, message.content, message.footer.tag())) return false;
  UncheckedWriter({place, message.content.size()}).put(message.content);
  return true;
}

// The check for a message that may be anywhere.
struct AnySurroundings {
  Status operator()(BytesView /*content*/) const { return {}; }
};

// Decrypts or verifies into the beginning of `out`, and returns the number of octets written. All
// checks of a protected message are made here. Only then is its session remembered. Its IV is
// remembered only after `fits(content)` confirms that the message is where its sender put it, so
// that a copy at another place uses up no IV.
template <class Fits = AnySurroundings>
[[gnu::always_inline]] inline Result<std::size_t> open_with_key(const ProtectedParts& message,
                                                                ReceiveKey& key, MutableBytes out,
                                                                Fits&& fits = {}) {
  DDSSEC_RETURN_IF_ERROR(check_header(key, message.header, message.is_encrypted));
  if (out.size() < message.content.size()) return fail(Code::length_out_of_range);
  if (key.precedes_key_exchange(message.header.iv)) return fail(Code::message_from_before);
  const bool origin = key.material().has_receiver_key();
  const auto ours =
      origin ? message.footer.receiver_mac(key.material().receiver_key_id) : std::nullopt;
  // This is checked before any cipher, because messages for other receivers come here often.
  if (origin && !ours) return fail(Code::receiver_specific_mac_missing);
  DDSSEC_ASSIGN_OR_RETURN(auto session, key.session(message.header.session_id));
  if (!open_content(message, session->key, out.data())) return fail(Code::tag_mismatch);
  if (origin && !session->receiver->verify(message.header.iv, message.footer.tag(), *ours)) {
    wipe(out.first(message.content.size()));
    return fail(Code::receiver_specific_mac_mismatch);
  }
  key.remember(std::move(session));
  auto status = fits(BytesView(out.first(message.content.size())));
  if (status && key.is_repeated(message.header.iv)) status = fail(Code::message_repeated);
  if (status) return message.content.size();
  wipe(out.first(message.content.size()));
  return std::unexpected(std::move(status).error());
}

// Returns the newest key of a remote entity at one level, if its tokens have come.
Result<ReceiveKey*> received(const PublishedPointer<RemoteKeys>& keys, KeyLevel level) {
  const auto* const published = keys.read();
  if (published == nullptr || !(published->*level)) return fail(Code::key_material_not_received);
  return (published->*level).get();
}

// Returns the key of the revision that the message names. If the kind differs in anything else,
// returns the newest key, so that check_header reports the difference.
[[gnu::cold]] Result<ReceiveKey*> of_revision(const CryptographyState& state,
                                              const PublishedPointer<RemoteKeys>& keys,
                                              KeyLevel level, ReceiveKey& newest,
                                              TransformKind named) {
  if (named.octets[3] != newest.material().kind.octets[3]) return &newest;
  if (const auto* const published = keys.read(); published != nullptr)
    if (auto* const key = former_key(*published, level, named, state.services.clock.monotonic()))
      return key;
  return fail(Code::key_revision_unknown);
}

// The newest key of a remote entity at one level, and where its former ones are.
struct KeyOfLevel {
  const CryptographyState& state;
  const PublishedPointer<RemoteKeys>& keys;
  KeyLevel level;
  ReceiveKey& newest;
};

// Decrypts a message with the newest key, or with a former one if the message names its revision.
template <class Fits = AnySurroundings>
Result<std::size_t> open_with_any_revision(const KeyOfLevel& of, const ProtectedParts& message,
                                           MutableBytes out, Fits&& fits = {}) {
  auto* key = &of.newest;
  if (message.header.kind != of.newest.material().kind) [[unlikely]] {
    DDSSEC_ASSIGN_OR_RETURN(
        key, of_revision(of.state, of.keys, of.level, of.newest, message.header.kind));
  }
  return open_with_key(message, *key, out, fits);
}

// Returns the key for submessages. Both sides of a key exchange share one key, and the host takes
// the sender's name from an RTPS header that any participant can write. Local messages that an
// attacker sends back are therefore recognised by their session.
Result<ReceiveKey*> submessage_key(const RemoteEndpointCrypto& sender, SessionId session) {
  if (!sender.local.is_volatile) return received(sender.remote_keys, &LevelKeys::submessage);
  const auto* const pair = sender.participant.pair(sender.local.participant.handle());
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  if (pair->key_exchange_send->has_begun(session)) return fail(Code::key_exchange_reflected);
  return pair->key_exchange_receive.get();
}

// True for the kinds of submessage that the owner of a writer's or reader's key may send. Fast DDS
// protects a writer's INFO_TS in its own group. The volatile endpoints of a participant share one
// key.
bool may_send(const RemoteEndpointCrypto& sender, std::uint8_t id) {
  using namespace submessage_id;
  constexpr std::array kWriters = {kData,          kDataFrag, kHeartbeat,
                                   kHeartbeatFrag, kGap,      kInfoTimestamp};
  constexpr std::array kReaders = {kAckNack, kNackFrag};
  const bool writer = std::ranges::find(kWriters, id) != kWriters.end();
  const bool reader = std::ranges::find(kReaders, id) != kReaders.end();
  if (sender.local.is_volatile) return writer || reader;
  return sender.kind() == EntityKind::remote_writer ? writer : reader;
}

// Success if `plain` is exactly one submessage in whole words, as the host reads it, and of a kind
// that its sender may send.
Status check_submessage(const RemoteEndpointCrypto& sender, BytesView plain) {
  if (plain.size() % 4 != 0 || size_of_first_submessage(plain) != plain.size())
    return fail(Code::secure_group_malformed,
                {.note = "its tag is right: the owner of its key sent it or, without origin "
                         "authentication, another participant that was given this key"});
  if (!may_send(sender, read_submessage_header(plain).id))
    return fail(Code::submessage_not_of_sender);
  return {};
}

class DiscoveryOfOne final : public DiscoveryOfPeers {
 public:
  DiscoveryOfOne(PeerDiscovery& peer, const Clock& clock) : peer_(peer), clock_(clock) {}
  PeerDiscovery* of(const GuidPrefix&) override { return &peer_; }
  MonotonicTime now() const override { return clock_.monotonic(); }

 private:
  PeerDiscovery& peer_;
  const Clock& clock_;
};

// Checks a sample of a protected builtin writer, and hides its type information from the host.
Status check_discovery(const CryptographyState& state, const RemoteEndpointCrypto& sender,
                       const Owner& owner, MutableBytes plain) {
  DiscoveryOfOne peers(sender.participant.discovery, state.services.clock);
  DDSSEC_ASSIGN_OR_RETURN(const auto types, check_builtin_source(plain, owner, peers));
  if (types && !sender.local.participant.trusts_type_information)
    hide_type_information(plain, *types);
  return {};
}

bool is_reported(const CryptographyState& state, const RemoteEndpointCrypto& sender,
                 const Error& error) {
  if (error.code() == Code::announcements_delayed)
    return sender.participant.discovery.work.take_report(state.services.clock.monotonic());
  return error.code() != Code::crypto_tokens_repeated &&
         error.code() != Code::crypto_tokens_early && error.code() != Code::builtin_fragment_early;
}

// Success unless a peer asks for fragments of key tokens that it was not sent.
Status check_requested(const CryptographyState& state, const RemoteEndpointCrypto& sender,
                       BytesView plain) {
  if (!sender.local.is_volatile) return {};
  const auto* const pair = sender.participant.pair(sender.local.participant.handle());
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  auto status = check_fragment_request(plain, pair->fragmented_tokens);
  if (!status) state.report(status.error(), pair->peer_prefix);
  return status;
}

// Makes all source checks, for a host that would trust any source and endpoint that the submessage
// names.
Status check_source_named(CryptographyState& state, const RemoteEndpointCrypto& sender,
                          MutableBytes plain) {
  if (state.host_checks_sources) return {};
  const auto* const pair = sender.participant.pair(sender.local.participant.handle());
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  auto status = check_token_source(plain, sender.local.is_volatile, pair->peer_prefix);
  if (status) {
    DDSSEC_RETURN_IF_ERROR(check_speaker(sender, plain));
    status = check_discovery(state, sender, pair->peer_prefix, plain);
  }
  if (status && sender.local.is_volatile) status = keep_tokens(state, sender, *pair, plain);
  if (!status && is_reported(state, sender, status.error()))
    state.report(status.error(), pair->peer_prefix);
  return status;
}

// Raises an event, because no honest owner of the key protects such a submessage.
void report_form(const CryptographyState& state, const RemoteEndpointCrypto& sender,
                 const Error& error) {
  const auto* const pair = sender.participant.pair(sender.local.participant.handle());
  if (pair != nullptr) state.report(error, pair->peer_prefix);
}

// Returns the sender, if it is matched with the receiver, whose participant still receives.
template <class Local, class Remote>
Result<const RemoteEndpointCrypto*> matched_sender(const CryptographyState& state, Local receiver,
                                                   Remote sender) {
  DDSSEC_ASSIGN_OR_RETURN(const auto* const local,
                          state.local_endpoint(receiver, local_kind(receiver)));
  DDSSEC_ASSIGN_OR_RETURN(const auto* const remote,
                          state.remote_endpoint(sender, remote_kind(sender)));
  if (&remote->local != local) return fail(Code::crypto_not_matched);
  DDSSEC_RETURN_IF_ERROR(check_not_cut_off(local->participant));
  return remote;
}

template <class Local, class Remote>
Result<std::size_t> decode_submessage(CryptographyState& state, Local receiver, Remote sender,
                                      BytesView encoded, MutableBytes out) {
  const ReadGuard guard;
  DDSSEC_ASSIGN_OR_RETURN(const auto* const found, matched_sender(state, receiver, sender));
  const auto& remote = *found;
  if (!is_protected(remote.local.submessage)) return fail(Code::not_protected);
  DDSSEC_ASSIGN_OR_RETURN(const auto message, read_protected_group(encoded, kSubmessageFrame));
  DDSSEC_ASSIGN_OR_RETURN(const auto found_key, submessage_key(remote, message.header.session_id));
  auto& key = *found_key;
  DDSSEC_ASSIGN_OR_RETURN(
      const auto size, open_with_any_revision(
                           {state, remote.remote_keys, &LevelKeys::submessage, key}, message, out));
  const auto plain = out.first(size);
  auto status = check_submessage(remote, plain);
  if (!status) [[unlikely]]
    report_form(state, remote, status.error());
  else
    status = check_requested(state, remote, plain);
  if (status) status = check_source_named(state, remote, plain);
  if (!status) {
    wipe(plain);
    return std::unexpected(std::move(status).error());
  }
  return size;
}

// The order of octets of the GUID prefix in a header (CryptographyOptions).
enum class PrefixOrder : std::uint8_t { network, host };

// Returns the header's version, vendor and GUID prefix, in network order.
std::array<std::uint8_t, 16> source_of(BytesView rtps_header, PrefixOrder order) {
  std::array<std::uint8_t, 16> source;
  std::ranges::copy(rtps_header.subspan(4, 16), source.begin());
  if (order == PrefixOrder::host && std::endian::native == std::endian::little)
    for (auto word = source.begin() + 4; word != source.end(); word += 4)
      std::reverse(word, word + 4);
  return source;
}

// The header is not authenticated, but the INFO_SRC inside is, so both must name the same source.
// Another INFO_SRC may follow: Cyclone DDS puts submessages of several participants of one process
// into one message. A host that does not check sources gets only the sender's part
// (sender_part.hpp).
Status check_source(BytesView content, const std::array<std::uint8_t, 16>& outside) {
  if (content.size() < kInfoSourceSize) return fail(Code::info_source_missing);
  const auto header = read_submessage_header(content);
  if (header.id != submessage_id::kInfoSource ||
      header.length != kInfoSourceSize - kSubmessageHeaderSize)
    return fail(Code::info_source_missing);
  if (!std::ranges::equal(content.subspan(8, 16), outside)) return fail(Code::info_source_mismatch);
  return {};
}

// Opens a message. `open_group(message, out, fits)` decrypts with a key of the caller's choice. If
// `fits(content)` refuses the content, it must return an error.
template <class F>
Result<std::size_t> open_message(BytesView encoded, Frame frame, MutableBytes out,
                                 PrefixOrder order, F&& open_group) {
  if (encoded.size() < kRtpsHeaderSize || as_text(encoded.first(4)) != "RTPS")
    return fail(Code::secure_group_malformed);
  DDSSEC_ASSIGN_OR_RETURN(const auto message,
                          read_protected_group(encoded.subspan(kRtpsHeaderSize), frame));
  if (out.size() < kRtpsHeaderSize) return fail(Code::length_out_of_range);
  const auto content = out.subspan(kRtpsHeaderSize);
  const auto source = source_of(encoded, order);
  const auto fits = [&](BytesView plain) { return check_source(plain, source); };
  DDSSEC_ASSIGN_OR_RETURN(const auto size, open_group(message, content, fits));
  // INFO_SRC stays first, and the header gets the same values, in network order.
  UncheckedWriter pen(out);
  pen.put(encoded.first(4));
  pen.put(source);
  return kRtpsHeaderSize + size;
}

}  // namespace

Result<std::size_t> open_message(BytesView encoded, Frame frame, ReceiveKey& key,
                                 MutableBytes out) {
  return open_message(encoded, frame, out, PrefixOrder::network,
                      [&](const ProtectedParts& message, MutableBytes to, const auto& fits) {
                        return open_with_key(message, key, to, fits);
                      });
}

Result<std::size_t> Transform::decode_serialized_payload(spi::DatareaderCryptoHandle receiver,
                                                         spi::DatawriterCryptoHandle sender,
                                                         BytesView encoded, MutableBytes out) {
  const ReadGuard guard;
  DDSSEC_ASSIGN_OR_RETURN(const auto* const found, matched_sender(state_, receiver, sender));
  const auto& remote = *found;
  if (!is_protected(remote.local.payload)) return fail(Code::not_protected);
  DDSSEC_ASSIGN_OR_RETURN(const auto found_key, received(remote.remote_keys, &LevelKeys::payload));
  auto& key = *found_key;
  DDSSEC_ASSIGN_OR_RETURN(const auto protected_payload, read_protected_payload(encoded));
  return open_with_any_revision({state_, remote.remote_keys, &LevelKeys::payload, key},
                                protected_payload, out);
}

Result<std::size_t> Transform::decode_datawriter_submessage(spi::DatareaderCryptoHandle receiver,
                                                            spi::DatawriterCryptoHandle sender,
                                                            BytesView encoded, MutableBytes out) {
  return decode_submessage(state_, receiver, sender, encoded, out);
}

Result<std::size_t> Transform::decode_datareader_submessage(spi::DatawriterCryptoHandle receiver,
                                                            spi::DatareaderCryptoHandle sender,
                                                            BytesView encoded, MutableBytes out) {
  return decode_submessage(state_, receiver, sender, encoded, out);
}

Result<std::size_t> Transform::decode_rtps_message(spi::ParticipantCryptoHandle receiver,
                                                   spi::ParticipantCryptoHandle sender,
                                                   BytesView encoded, MutableBytes out) {
  DDSSEC_ASSIGN_OR_RETURN(const auto size, open_message_of(receiver, sender, encoded, out));
  return state_.host_checks_sources ? size : keep_part_of_sender(receiver, sender, out.first(size));
}

Result<std::size_t> Transform::open_message_of(spi::ParticipantCryptoHandle receiver,
                                               spi::ParticipantCryptoHandle sender,
                                               BytesView encoded, MutableBytes out) {
  const ReadGuard guard;
  DDSSEC_ASSIGN_OR_RETURN(const auto local_participant, state_.local_participant(receiver));
  const auto& local = *local_participant;
  DDSSEC_RETURN_IF_ERROR(check_not_cut_off(local));
  DDSSEC_ASSIGN_OR_RETURN(const auto remote_participant, state_.remote_participant(sender));
  const auto* const pair = remote_participant->pair(receiver.value);
  if (pair == nullptr) return fail(Code::crypto_not_matched);
  if (!is_protected(local.rtps)) return fail(Code::not_protected);
  DDSSEC_ASSIGN_OR_RETURN(const auto found_key,
                          received(pair->remote_keys, &LevelKeys::submessage));
  auto& key = *found_key;
  const auto order =
      state_.header_prefix_is_network_order ? PrefixOrder::network : PrefixOrder::host;
  return open_message(encoded, kMessageFrame, out, order,
                      [&](const ProtectedParts& message, MutableBytes to, const auto& fits) {
                        return open_with_any_revision(
                            {state_, pair->remote_keys, &LevelKeys::submessage, key}, message, to,
                            fits);
                      });
}

Result<spi::SecureSubmessage> Transform::preprocess_secure_submessage(
    spi::ParticipantCryptoHandle receiver, spi::ParticipantCryptoHandle sender, BytesView encoded) {
  const ReadGuard guard;
  DDSSEC_ASSIGN_OR_RETURN(const auto remote_participant, state_.remote_participant(sender));
  const auto& remote = *remote_participant;
  if (receiver) DDSSEC_RETURN_IF_ERROR(state_.local_participant(receiver));
  DDSSEC_ASSIGN_OR_RETURN(const auto header, read_prefix(encoded, kSubmessageFrame));
  const auto* const endpoint = remote.routes.find(header.key_id, receiver.value, encoded);
  if (endpoint == nullptr) return fail(Code::unknown_key_id);
  // Without INFO_DST, a host that does not check sources passes a key token message to all its
  // participants, and would hold its ticket twice.
  if (endpoint->local.is_volatile && !receiver && !state_.host_checks_sources)
    return fail(Code::key_exchange_undirected);
  const auto ours = endpoint->local.handle(), theirs = endpoint->handle();
  if (endpoint->kind() == EntityKind::remote_writer)
    return spi::SecureSubmessage{spi::SecureSubmessageCategory::datawriter, {theirs}, {ours}};
  return spi::SecureSubmessage{spi::SecureSubmessageCategory::datareader, {ours}, {theirs}};
}

}  // namespace ddssec::cryptography
