// CryptoTransform: the message path. It makes one malloc block for each result, and no other
// allocation.
#include <cstring>

#include "plugins/cyclonedds/buffers.hpp"
#include "plugins/cyclonedds/cryptography_adapter.hpp"
#include "plugins/cyclonedds/opened_message.hpp"
#include "plugins/cyclonedds/peers_with_keys.hpp"
#include "plugins/cyclonedds/process_questions.hpp"
#include "plugins/cyclonedds/session_resets.hpp"

namespace ddssec::cyclonedds {
namespace {

using Adapter = CryptographyAdapter;
using Instance = dds_security_crypto_transform;
using CHandle = DDS_Security_CryptoHandle;
using Octets = DDS_Security_OctetSeq;

// The size of SEC_PREFIX: submessage header and CryptoHeader. A decoded submessage must fit into
// the octets after it.
constexpr std::size_t kSecurePrefixSize = 24;

Status encode_serialized_payload(Adapter& adapter, Octets& out, const Octets* plain,
                                 CHandle sender) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, octets_from(plain));
  return write_block(out, octets.size() + spi::protection_overhead(0), [&](MutableBytes room) {
    return adapter.transform().encode_serialized_payload({sender}, octets, room);
  });
}

// Calls `encode(octets, receivers, room)` for all receivers at once.
template <class Handle, class Encode>
Status encode_for(Octets& out, const Octets* plain, const DDS_Security_LongLongSeq* list,
                  Encode&& encode) {
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, octets_from(plain));
  if (octets.empty()) return fail(Code::null_argument);
  std::vector<Handle> kept;
  DDSSEC_ASSIGN_OR_RETURN(const auto receivers, receivers_from(list, kept));
  const auto bound = octets.size() + spi::protection_overhead(receivers.size());
  return write_block(out, bound,
                     [&](MutableBytes room) { return encode(octets, receivers, room); });
}

// Ends the host's loop over receivers after the first call.
void end_loop(DDS_Security_long* index, const DDS_Security_LongLongSeq* list) {
  if (index != nullptr && list != nullptr) *index = static_cast<DDS_Security_long>(list->_length);
}

DDS_Security_boolean encode_serialized_payload(Instance* instance, Octets* encoded, Octets*,
                                               const Octets* plain, const CHandle sender,
                                               Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(encoded));
    return encode_serialized_payload(adapter, *encoded, plain, sender);
  });
}

DDS_Security_boolean encode_datawriter_submessage(
    Instance* instance, Octets* encoded, const Octets* plain, const CHandle sender,
    const DDS_Security_DatareaderCryptoHandleSeq* list, DDS_Security_long* index, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(encoded));
    OwnReaders::Room end;
    DDSSEC_RETURN_IF_ERROR(encode_for<spi::DatareaderCryptoHandle>(
        *encoded, plain, list, [&](BytesView octets, auto receivers, MutableBytes room) {
          return adapter.transform().encode_datawriter_submessage(
              {sender}, receivers, adapter.own_readers().said(sender, octets, end), room);
        }));
    end_loop(index, list);
    return {};
  });
}

DDS_Security_boolean encode_datareader_submessage(
    Instance* instance, Octets* encoded, const Octets* plain, const CHandle sender,
    const DDS_Security_DatawriterCryptoHandleSeq* list, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(encoded));
    return encode_for<spi::DatawriterCryptoHandle>(
        *encoded, plain, list, [&](BytesView octets, auto receivers, MutableBytes room) {
          return adapter.transform().encode_datareader_submessage({sender}, receivers, octets,
                                                                  room);
        });
  });
}

DDS_Security_boolean encode_rtps_message(Instance* instance, Octets* encoded, const Octets* plain,
                                         const CHandle sender,
                                         const DDS_Security_ParticipantCryptoHandleSeq* list,
                                         DDS_Security_long* index, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(encoded));
    DDSSEC_RETURN_IF_ERROR(encode_for<spi::ParticipantCryptoHandle>(
        *encoded, plain, list, [&](BytesView octets, auto receivers, MutableBytes room) {
          return adapter.transform().encode_rtps_message({sender}, receivers, octets, room);
        }));
    end_loop(index, list);
    return {};
  });
}

// The result must fit where the host copies it without a check, and end at a multiple of 4 where
// submessages follow one another.
Status check_decoded(Octets& decoded, std::size_t max_octets, std::size_t alignment) {
  if (decoded._length <= max_octets && decoded._length % alignment == 0) return {};
  wipe({decoded._buffer, decoded._length});
  std::free(decoded._buffer);
  const auto code = decoded._length > max_octets ? Code::result_exceeds_buffer : Code::malformed;
  decoded = {};
  return fail(code);
}

// The host reads a submessage that is only signed in the received buffer. So the decoded content,
// which can differ (cryptography/type_information.hpp), is written there.
void write_where_received(const Octets& plain, const Octets& encoded) {
  constexpr std::uint8_t kSecureBody = 0x30;
  auto* const received = encoded._buffer + kSecurePrefixSize;
  if (*received != kSecureBody) std::memmove(received, plain._buffer, plain._length);
}

// Calls `decode(octets, room)`.
template <class Decode>
Status decode_submessage(Octets* plain, const Octets* encoded, Decode&& decode) {
  DDSSEC_RETURN_IF_ERROR(require(plain));
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, octets_from(encoded));
  if (octets.size() <= kSecurePrefixSize) return fail(Code::truncated);
  DDSSEC_RETURN_IF_ERROR(
      write_block(*plain, octets.size(), [&](MutableBytes room) { return decode(octets, room); }));
  DDSSEC_RETURN_IF_ERROR(check_decoded(*plain, octets.size() - kSecurePrefixSize, 4));
  write_where_received(*plain, *encoded);
  return {};
}

// Before a peer's keys have arrived, only messages of the key exchange, which the shared secret
// protects, show that the peer is alive.
void note_heard(Adapter& adapter, CHandle sender) {
  auto& peers = PeersWithKeys::of_process();
  if (peers.awaits_keys()) peers.note_heard(sender, adapter.host().clock().monotonic());
}

// This code makes the host ask for its next local participant. Any other code ends the message.
constexpr DDS_Security_long kAskNext = DDS_SECURITY_ERR_INVALID_CRYPTO_RECEIVER_SIGN_CODE;

// Cyclone asks for each local participant in turn. A message may be for the next participant if it
// has no MAC for this one, if the sender's keys have not arrived yet, or if it is older than they
// are. Such errors are no reason for an alarm.
FailureReport as_one_of_several_receivers(const Error& error) {
  auto report = default_report(error);
  if (error.code() == Code::receiver_specific_mac_missing || error.code() == Code::identity_ended)
    report.severity = Severity::debug;
  if (error.code() == Code::receiver_specific_mac_missing ||
      error.code() == Code::receiver_specific_mac_mismatch ||
      error.code() == Code::identity_ended || error.code() == Code::message_from_before ||
      error.code() == Code::key_material_not_received)
    report.host_code = kAskNext;
  return report;
}

Status decode_rtps_message(Adapter& adapter, Octets* plain, const Octets* encoded, CHandle receiver,
                           CHandle sender) {
  DDSSEC_RETURN_IF_ERROR(require(plain));
  DDSSEC_ASSIGN_OR_RETURN(const auto octets, octets_from(encoded));
  DDSSEC_RETURN_IF_ERROR(write_block(*plain, octets.size(), [&](MutableBytes room) {
    const WireOrderPrefix as_on_the_wire(octets);
    return adapter.transform().decode_rtps_message({receiver}, {sender}, octets, room);
  }));
  return check_decoded(*plain, octets.size(), 4);
}

DDS_Security_boolean decode_rtps_message(Instance* instance, Octets* plain, const Octets* encoded,
                                         const CHandle receiver, const CHandle sender,
                                         Exception* ex) {
  if (instance == nullptr) return ask<Adapter>(instance, ex, [](Adapter&) { return Status{}; });
  auto& opened = OpenedMessage::of_this_thread();
  const MessageCall call{
      instance, receiver, sender,
      encoded != nullptr ? octets_from(encoded).value_or(BytesView()) : BytesView()};
  // A reset contains nothing for the host. An invalid one is ignored.
  const auto reset = spi::read_reset(call.octets);
  if (reset && SessionResets::of_process().note_reset(*reset)) end_sessions_now();
  // The host already has the plaintext. Another result would replace it, and the first one would
  // leak.
  if (reset || opened.was_opened_for_another(call)) {
    if (ex != nullptr) *ex = {.message = nullptr, .code = kAskNext, .minor_code = 0};
    return 0;
  }
  auto& adapter = Adapter::of(*instance);
  const bool done =
      at_c_boundary(
          adapter.host(), ex,
          [&] { return decode_rtps_message(adapter, plain, encoded, receiver, sender); },
          as_one_of_several_receivers)
          .has_value();
  if (done) opened.remember(call);
  return done ? 1 : 0;
}

DDS_Security_boolean preprocess_secure_submsg(Instance* instance, CHandle* datawriter,
                                              CHandle* datareader,
                                              DDS_Security_SecureSubmessageCategory_t* category,
                                              const Octets* encoded, const CHandle receiver,
                                              const CHandle sender, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(datawriter, datareader, category));
    *datawriter = DDS_SECURITY_HANDLE_NIL;
    *datareader = DDS_SECURITY_HANDLE_NIL;
    *category = DDS_SECURITY_INFO_SUBMESSAGE;
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, octets_from(encoded));
    DDSSEC_ASSIGN_OR_RETURN(const auto found, adapter.transform().preprocess_secure_submessage(
                                                  {receiver}, {sender}, octets));
    // Success without an endpoint would leave an empty buffer to the host.
    if (found.category == spi::SecureSubmessageCategory::info) return fail(Code::nothing_to_route);
    *datawriter = found.datawriter.value;
    *datareader = found.datareader.value;
    *category = found.category == spi::SecureSubmessageCategory::datawriter
                    ? DDS_SECURITY_DATAWRITER_SUBMESSAGE
                    : DDS_SECURITY_DATAREADER_SUBMESSAGE;
    return {};
  });
}

DDS_Security_boolean decode_datawriter_submessage(Instance* instance, Octets* plain,
                                                  const Octets* encoded, const CHandle receiver,
                                                  const CHandle sender, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) {
    auto decoded = decode_submessage(plain, encoded, [&](BytesView octets, MutableBytes room) {
      return adapter.transform().decode_datawriter_submessage({receiver}, {sender}, octets, room);
    });
    if (decoded) note_heard(adapter, sender);
    return decoded;
  });
}

DDS_Security_boolean decode_datareader_submessage(Instance* instance, Octets* plain,
                                                  const Octets* encoded, const CHandle receiver,
                                                  const CHandle sender, Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) {
    auto decoded = decode_submessage(plain, encoded, [&](BytesView octets, MutableBytes room) {
      return adapter.transform().decode_datareader_submessage({receiver}, {sender}, octets, room);
    });
    if (decoded) note_heard(adapter, sender);
    return decoded;
  });
}

DDS_Security_boolean decode_serialized_payload(Instance* instance, Octets* plain,
                                               const Octets* encoded, const Octets*,
                                               const CHandle receiver, const CHandle sender,
                                               Exception* ex) {
  return ask<Adapter>(instance, ex, [&](Adapter& adapter) -> Status {
    DDSSEC_RETURN_IF_ERROR(require(plain));
    DDSSEC_ASSIGN_OR_RETURN(const auto octets, octets_from(encoded));
    return write_block(*plain, octets.size(), [&](MutableBytes room) {
      return adapter.transform().decode_serialized_payload({receiver}, {sender}, octets, room);
    });
  });
}

}  // namespace

const dds_security_crypto_transform kTransformFunctions = {
    .encode_serialized_payload = encode_serialized_payload,
    .encode_datawriter_submessage = encode_datawriter_submessage,
    .encode_datareader_submessage = encode_datareader_submessage,
    .encode_rtps_message = encode_rtps_message,
    .decode_rtps_message = decode_rtps_message,
    .preprocess_secure_submsg = preprocess_secure_submsg,
    .decode_datawriter_submessage = decode_datawriter_submessage,
    .decode_datareader_submessage = decode_datareader_submessage,
    .decode_serialized_payload = decode_serialized_payload,
};

}  // namespace ddssec::cyclonedds
