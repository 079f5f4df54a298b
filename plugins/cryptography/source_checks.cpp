#include "plugins/cryptography/source_checks.hpp"

#include <algorithm>

#include "base/reader.hpp"
#include "plugins/cryptography/wire.hpp"

namespace ddssec::cryptography {
namespace {

/// ParticipantVolatileMessageSecureWriter (DDS-Security 7.4.5).
constexpr EntityId kVolatileWriter{{0xff, 0x02, 0x02, 0xc3}};

constexpr std::uint8_t kInlineQosFlag = 0x02;
constexpr std::uint8_t kDataFlag = 0x04;     ///< of DATA
constexpr std::uint8_t kKeyFlag = 0x08;      ///< of DATA
constexpr std::uint8_t kFragKeyFlag = 0x04;  ///< of DATA_FRAG
constexpr std::uint16_t kSentinel = 1;

// ParticipantGenericMessage (DDS-Security 7.4.4.4) begins with GUIDs and sequence numbers only:
// each of its places is the same in every byte order and in plain CDR 1 and 2.
constexpr std::size_t kSourceAt = 4;           ///< message_identity.source_guid
constexpr std::size_t kSourceEndpointAt = 84;  ///< source_endpoint_guid
constexpr std::size_t kAddressesSize = 100;    ///< up to message_class_id

// ---- whole messages

/// The octets of the first submessage, header included; nothing where Cyclone DDS stops reading.
std::optional<std::size_t> size_of_first(BytesView octets) {
  if (octets.size() < kSubmessageHeaderSize) return std::nullopt;
  const auto header = read_submessage_header(octets);
  if (header.length == 0) {
    constexpr std::uint8_t kPad = 0x01;
    const bool may_be_empty = header.id == kPad || header.id == submessage_id::kInfoTimestamp;
    return may_be_empty ? kSubmessageHeaderSize : octets.size();
  }
  const auto size = kSubmessageHeaderSize + header.length;
  if (size > octets.size()) return std::nullopt;
  if (header.length % 4 != 0 && size != octets.size()) return std::nullopt;
  return size;
}

/// Cyclone DDS reads the lengths of a SEC_ group in the byte order of its SEC_PREFIX. With one
/// order in all three there is one way to read them.
bool is_of_one_order(BytesView group, std::size_t prefix_size) {
  const auto order = group[1] & kEndianFlag;
  auto rest = group.subspan(prefix_size);
  for (int part = 0; part < 2; ++part) {
    const auto size = size_of_first(rest);
    if (!size || (rest[1] & kEndianFlag) != order) return false;
    rest = rest.subspan(*size);
  }
  return true;
}

bool are_of_one_subject(const GuidPrefix& a, const GuidPrefix& b) {
  return std::equal(a.octets.begin(), a.octets.begin() + 6, b.octets.begin());
}

Error unreadable() {
  return Error(Code::secure_group_malformed, {.document = "a protected message"});
}

/// Why the sender's part ends before this submessage, if it does.
std::optional<Error> end_before(BytesView rest, std::size_t size, const GuidPrefix& sender) {
  const auto id = rest[0];
  if (id == submessage_id::kSecPrefix && !is_of_one_order(rest, size)) return unreadable();
  if (id != submessage_id::kInfoSource) return std::nullopt;
  if (size < kInfoSourceSize) return unreadable();
  const auto named = GuidPrefix::from(rest.subspan(12, GuidPrefix::size));
  if (named == sender || are_of_one_subject(named, sender)) return std::nullopt;
  return Error(Code::info_source_mismatch, {.document = "a protected message",
                                            .field = "INFO_SRC",
                                            .expected = sender.to_string(),
                                            .found = named.to_string(),
                                            .note = "what follows it was dropped"});
}

// ---- key tokens

/// Data, and nothing but data? Cyclone DDS reads a token message of which it got only the key, or
/// the hash of one, through a null pointer.
bool is_data(const SubmessageHeader& header) {
  if (header.id == submessage_id::kDataFrag) return (header.flags & kFragKeyFlag) == 0;
  return (header.flags & (kDataFlag | kKeyFlag)) == kDataFlag;
}

/// After writerSN: does it begin the sample? No fragment may end within the addresses, nor begin
/// there.
Result<bool> read_fragment(Reader& in) {
  const auto first = DDSSEC_TRY(in.read<std::uint32_t>());
  DDSSEC_TRY(in.skip(2));
  const auto size = DDSSEC_TRY(in.read<std::uint16_t>());
  const auto whole = DDSSEC_TRY(in.read<std::uint32_t>());
  if (first == 0 || size < kAddressesSize) return fail(Code::malformed);
  if (std::uint64_t{first - 1} * size >= whole) return fail(Code::malformed);
  return first == 1;
}

Status skip_inline_qos(Reader& in) {
  for (;;) {
    const auto id = DDSSEC_TRY(in.read<std::uint16_t>());
    const auto length = DDSSEC_TRY(in.read<std::uint16_t>());
    if (id == kSentinel) return {};
    if (length % 4 != 0) return fail(Code::malformed);
    DDSSEC_TRY(in.skip(length));
  }
}

/// The payload, from its encapsulation header on; empty if this piece does not begin a sample.
Result<BytesView> read_beginning(BytesView submessage) {
  const auto header = read_submessage_header(submessage);
  const bool is_fragment = header.id == submessage_id::kDataFrag;
  const bool little = (header.flags & kEndianFlag) != 0;
  Reader in(submessage, little ? Endian::little : Endian::big);
  DDSSEC_TRY(in.skip(kSubmessageHeaderSize + 2));
  const auto to_inline_qos = DDSSEC_TRY(in.read<std::uint16_t>());
  const auto counted_from = in.position();
  DDSSEC_TRY(in.skip(4 + 4 + 8));  // readerId, writerId, writerSN
  if (is_fragment && !DDSSEC_TRY(read_fragment(in))) return BytesView{};
  if (to_inline_qos % 4 != 0 || counted_from + to_inline_qos < in.position())
    return fail(Code::malformed);
  DDSSEC_TRY(in.skip(counted_from + to_inline_qos - in.position()));
  if ((header.flags & kInlineQosFlag) != 0) DDSSEC_TRY(skip_inline_qos(in));
  if (in.remaining() < kAddressesSize) return fail(Code::truncated);
  return in.rest();
}

/// Plain CDR 1 or 2, of either byte order.
bool is_plain_cdr(BytesView payload) {
  return payload[0] == 0 && (payload[1] <= 1 || payload[1] == 6 || payload[1] == 7);
}

std::unexpected<Error> unreadable_token(std::string_view why) {
  return fail(Code::token_source_unreadable,
              {.document = "a key token message", .note = std::string(why)});
}

Status check_name(std::string_view field, const GuidPrefix& expected, const GuidPrefix& found) {
  if (found == expected) return {};
  return fail(Code::token_source_mismatch, {.document = "a key token message",
                                            .field = std::string(field),
                                            .expected = expected.to_string(),
                                            .found = found.to_string()});
}

}  // namespace

SenderPart part_of_sender(BytesView content, const GuidPrefix& sender) {
  for (auto rest = content; !rest.empty();) {
    const auto here = content.size() - rest.size();
    const auto size = size_of_first(rest);
    if (!size) return {here, unreadable()};
    if (const auto id = rest[0];
        id == submessage_id::kInfoSource || id == submessage_id::kSecPrefix) {
      if (auto ended = end_before(rest, *size, sender)) return {here, std::move(ended)};
    }
    rest = rest.subspan(*size);
  }
  return {content.size(), std::nullopt};
}

Status check_token_source(BytesView submessage, bool is_key_exchange,
                          const std::optional<GuidPrefix>& peer) {
  const auto id = submessage[0];
  if (id != submessage_id::kData && id != submessage_id::kDataFrag) return {};
  constexpr std::size_t kWriterAt = 12;
  if (submessage.size() < kWriterAt + EntityId::size)
    return is_key_exchange ? unreadable_token("it ends too early") : Status();
  const auto writer = EntityId::from(submessage.subspan(kWriterAt, EntityId::size));
  if ((writer == kVolatileWriter) != is_key_exchange)
    return fail(Code::submessage_not_of_sender, {.field = "writerId", .found = writer.to_string()});
  if (!is_key_exchange) return {};
  if (!is_data(read_submessage_header(submessage)))
    return unreadable_token("it is not data, but a key or nothing");
  const auto payload = read_beginning(submessage);
  if (!payload) return unreadable_token("its lengths contradict one another");
  if (payload->empty()) return {};
  if (!is_plain_cdr(*payload)) return unreadable_token("its encapsulation is not plain CDR");
  const auto source = GuidPrefix::from(payload->subspan(kSourceAt, GuidPrefix::size));
  DDSSEC_TRY(check_name("message_identity.source_guid", peer.value_or(source), source));
  const auto endpoint = GuidPrefix::from(payload->subspan(kSourceEndpointAt, GuidPrefix::size));
  if (endpoint.is_zero()) return {};  // a participant's tokens
  return check_name("source_endpoint_guid", peer.value_or(source), endpoint);
}

}  // namespace ddssec::cryptography
