// The part of Keyring that protects and opens submessages and payloads.
#include <algorithm>

#include "plugins/spi/named_key_revision.hpp"
#include "rtps/security/keyring.hpp"

namespace ddssec::rtps {
namespace {

// True for the errors of a message that arrives too early or is meant for others. They raise no
// event.
bool is_expected(Code code) {
  return code == Code::key_material_not_received || code == Code::unknown_key_id ||
         code == Code::key_revision_unknown || code == Code::receiver_specific_mac_missing ||
         code == Code::receiver_count || code == Code::crypto_not_matched ||
         code == Code::message_from_before || code == Code::message_repeated;
}

// The two volatile endpoints of a participant share one key, which only this pair of participants
// has. Many participants have its other keys: with one of them, an insider could send key tokens in
// its name.
bool lacks_submessage_key(const LocalKeys& local, const Guid& remote,
                          const ReceivedProtection& opened_by) {
  const auto& [prefix, entity] = opened_by.submessage;
  const bool by_remote =
      local.is_volatile ? prefix == remote.prefix &&
                              (entity == kVolatileMessageWriter || entity == kVolatileMessageReader)
                        : opened_by.submessage == remote;
  return local.attributes.is_submessage_protected() && !by_remote;
}

Result<BytesView> open_payload_under(spi::CryptoTransform& transform, const LocalKeys& local,
                                     const Guid& writer, BytesView payload, MutableBytes scratch) {
  if (!local.attributes.is_payload_protected() || payload.empty()) return payload;
  const auto pair = local.pairs.find(writer);
  if (pair == local.pairs.end() || pair->second.is_suspended) return fail(Code::crypto_not_matched);
  DDSSEC_ASSIGN_OR_RETURN(
      const auto size,
      transform.decode_serialized_payload({local.handle}, {pair->second.handle}, payload, scratch));
  return scratch.first(size);
}

}  // namespace

bool is_plain_builtin(const EntityId& id) {
  return id == kPublicationsReader || id == kPublicationsWriter || id == kSubscriptionsReader ||
         id == kSubscriptionsWriter || id == kParticipantMessageReader ||
         id == kParticipantMessageWriter;
}

std::unexpected<Error> Keyring::undecodable_error(const Error& error, const GuidPrefix& sender) {
  ++counters_.undecodable;
  if (!is_expected(error.code())) events_.raise(peer_event(error, sender.to_string()));
  return std::unexpected(error);
}

Result<Keyring::OpenSubmessage> Keyring::open_submessage(const GuidPrefix& sender, BytesView group,
                                                         MutableBytes scratch) {
  const auto remote = remotes_.find(sender);
  if (remote == remotes_.end()) return undecodable_error(Error(Code::crypto_not_matched), sender);
  const auto found =
      transform().preprocess_secure_submessage(own_.crypto(), remote->second.crypto, group);
  if (!found) return undecodable_error(found.error(), sender);
  const bool by_writer = found->category == spi::SecureSubmessageCategory::datawriter;
  const auto size = by_writer ? transform().decode_datawriter_submessage(
                                    found->datareader, found->datawriter, group, scratch)
                              : transform().decode_datareader_submessage(
                                    found->datawriter, found->datareader, group, scratch);
  if (!size) return undecodable_error(size.error(), sender);
  const auto* by = keys_.endpoint_of(by_writer ? found->datawriter.value : found->datareader.value);
  if (by == nullptr) return undecodable_error(Error(Code::crypto_not_matched), sender);
  // Others have the former key, too, and the new document may deny them the topic.
  if (phases_.is_former(by->local, by->guid, by->protection))
    return undecodable_error(Error(Code::message_from_before), sender);
  const bool is_newest = spi::named_key_revision(group) == by->newest->revision;
  return OpenSubmessage{scratch.first(*size), by->guid, by->protection,
                        is_newest ? KeyAge::newest : KeyAge::former};
}

// With two protections, the key of the submessage says which one counts for the payload. Where
// neither protects submessages, both protect payloads (governance::live_change), and the payload
// names its key. A peer that has changed sends nothing more with the former ones.
Result<BytesView> Keyring::open_payload(const EntityId& reader, const Guid& writer,
                                        BytesView payload, const ReceivedProtection& opened_by,
                                        MutableBytes scratch) {
  const auto* local = find(reader);
  if (local == nullptr) return fail(Code::crypto_not_matched);
  if (const auto* next = phases_.only_next(reader, writer)) [[unlikely]] {
    const auto plain = open_payload_under(transform(), *next, writer, payload, scratch);
    return plain ? plain : undecodable_error(Error(Code::message_from_before), writer.prefix);
  }
  if (const auto* other = phases_.endpoints().second_keys_of(reader, writer)) [[unlikely]] {
    const bool by_key = opened_by.submessage == writer;
    const auto fits = [&](const LocalKeys& one) {
      return by_key ? one.protection == opened_by.protection
                    : !one.attributes.is_submessage_protected();
    };
    const bool fits_first = local->pairs.contains(writer) && fits(*local);
    if (!fits_first) {
      local = other;
    } else if (fits(*other)) {
      const auto plain = open_payload_under(transform(), *other, writer, payload, scratch);
      if (plain) return plain;
    }
  }
  const auto plain = open_payload_under(transform(), *local, writer, payload, scratch);
  if (!plain && plain.error().code() != Code::crypto_not_matched)
    return undecodable_error(plain.error(), writer.prefix);
  return plain;
}

bool Keyring::accepts(const EntityId& id, const Guid& remote, const ReceivedProtection& opened_by) {
  const auto* local = phases_.demanded(id, remote);
  if (local == nullptr) return false;
  const auto peer = remotes_.find(remote.prefix);
  const bool may_come_bare =
      local->is_volatile ||
      (is_plain_builtin(id) && (peer == remotes_.end() || !peer->second.wraps_plain_builtin));
  const bool message_missing =
      phases_.must_protect_messages(remote.prefix) && !opened_by.message && !may_come_bare;
  const bool submessage_missing = lacks_submessage_key(*local, remote, opened_by);
  if (!message_missing && !submessage_missing) {
    // The key may have been found by way of another endpoint, which has no second protection.
    const bool is_former =
        opened_by.submessage == remote && phases_.is_former(id, remote, opened_by.protection);
    if (is_former)
      static_cast<void>(undecodable_error(Error(Code::message_from_before), remote.prefix));
    return !is_former;
  }
  ++counters_.unprotected;
  events_.raise(
      peer_event(Error(Code::rtps_protection_missing,
                       {.document = "endpoint " + id.to_string(),
                        .expected = message_missing ? "a protected message"
                                                    : "a submessage protected by its sender",
                        .found = "an unprotected one"}),
                 remote.to_string()));
  return false;
}

bool shows_receiver(const Keyring& keyring, const EntityId& writer, const Guid& reader,
                    const ReceivedProtection& opened_by) {
  if (opened_by.message) return true;
  const auto* local = keyring.find(writer);
  if (local == nullptr || opened_by.submessage == Guid{}) return false;
  if (local->is_volatile || !is_builtin(writer)) return true;
  if (local->protection != opened_by.protection)
    local = keyring.phases().endpoints().second_keys_of(writer, reader);
  return local != nullptr && local->protection == opened_by.protection &&
         spi::is_origin_authenticated(local->attributes.submessage);
}

bool is_only_payload_proven(const Keyring& keyring, const EntityId& local, const Guid& remote,
                            const ReceivedProtection& opened_by) {
  if (opened_by.message || opened_by.submessage == remote) return false;
  const auto* demanded = keyring.phases().demanded(local, remote);
  return demanded != nullptr && demanded->attributes.is_payload_protected();
}

void Keyring::note_unproven_end(const EntityId& id, const Guid& remote, std::string found) {
  ++counters_.unprotected;
  events_.raise(peer_event(Error(Code::rtps_protection_missing,
                                 {.document = "endpoint " + id.to_string(),
                                  .expected = "the protected key of the instance that ends",
                                  .found = std::move(found)}),
                           remote.to_string()));
}

// ---- SendProtection

Keyring::Levels Keyring::levels(const EntityId& sender) const {
  constexpr std::size_t kHeaderAndFooter = 128, kReceiverMac = 20;
  constexpr std::size_t kMorePeers = 16;  // peers that may be added before the message is finished
  const auto* local = find(sender);
  // SPDP and the stateless endpoint are not in the keyring, because peers must be able to read them
  // before authentication.
  if (local == nullptr) return {.message = pre_shared_.wrap(), .message_room = kHeaderAndFooter};
  const auto kind = phases_.messages().kind();
  const bool is_by_participant = is_protected(kind) && !local->is_volatile;
  const bool has_message_macs = is_by_participant && spi::is_origin_authenticated(kind);
  const auto macs =
      has_message_macs ? kReceiverMac * (phases_.messages().receivers() + kMorePeers) : 0;
  return {.payload = local->attributes.is_payload_protected(),
          .submessage = local->attributes.is_submessage_protected(),
          .message = is_by_participant ? Wrap::participant_key : pre_shared_.wrap(),
          .message_room = kHeaderAndFooter + macs,
          .receiver_macs =
              !local->is_volatile && spi::is_origin_authenticated(local->attributes.submessage)};
}

Result<std::size_t> Keyring::protect_payload(const EntityId& writer, BytesView plain,
                                             MutableBytes out) {
  const auto* local = find(writer);
  if (local == nullptr) return fail(Code::crypto_not_matched);
  return transform().encode_serialized_payload({local->handle}, plain, out);
}

Result<std::size_t> Keyring::protect_submessage(const EntityId& sender, const Guid& receiver,
                                                BytesView plain, MutableBytes out) {
  const auto* local = find(sender);
  if (local == nullptr) return fail(Code::crypto_not_matched);
  const bool to_all = receiver.prefix.is_zero() || receiver.entity == kEntityIdUnknown;
  std::int64_t one = 0;
  if (!to_all) {
    const auto pair = local->pairs.find(receiver);
    if (pair == local->pairs.end() || pair->second.is_suspended)
      return fail(Code::crypto_not_matched);
    one = pair->second.handle;
  }
  if (is_writer(sender)) {
    const spi::DatareaderCryptoHandle reader{one};
    return transform().encode_datawriter_submessage(
        {local->handle}, to_all ? std::span(local->readers) : std::span(&reader, 1), plain, out);
  }
  const spi::DatawriterCryptoHandle writer{one};
  return transform().encode_datareader_submessage(
      {local->handle}, to_all ? std::span(local->writers) : std::span(&writer, 1), plain, out);
}

void Keyring::on_unprotectable(const Error& error) {
  ++counters_.unsendable;
  if (!is_expected(error.code())) events_.raise(Event(error));
}

}  // namespace ddssec::rtps
