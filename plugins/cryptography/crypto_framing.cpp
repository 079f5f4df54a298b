#include "plugins/cryptography/crypto_framing.hpp"

#include <utility>

#include "plugins/cryptography/key_material.hpp"

namespace ddssec::cryptography {
namespace {

std::uint32_t u32_at(BytesView octets, std::size_t position) {
  std::uint32_t value;
  std::memcpy(&value, octets.data() + position, sizeof value);
  return big_endian(value);
}

template <class Id>
Id id_at(BytesView octets, std::size_t position) {
  Id id;
  std::memcpy(id.octets.data(), octets.data() + position, Id::size);
  return id;
}

CryptoHeader crypto_header_at(BytesView octets) {
  CryptoHeader header;
  header.kind = id_at<TransformKind>(octets, 0);
  header.key_id = id_at<KeyId>(octets, 4);
  header.session_id = id_at<SessionId>(octets, 8);
  std::memcpy(header.iv.data(), octets.data() + 8, header.iv.size());
  return header;
}

// True for GCM, false for GMAC. Parsing depends on nothing else.
Result<bool> encrypts(const CryptoHeader& header) {
  const auto traits = traits_of(header.kind);
  if (!traits) return fail(Code::crypto_header_kind_unknown);
  return traits->encrypts;
}

// The count must match the octets exactly, so it never controls a loop or an allocation.
Result<CryptoFooter> footer_from(BytesView octets) {
  if (octets.size() < kFooterSize) return fail(Code::secure_group_malformed);
  const std::uint64_t count = u32_at(octets, kTagSize);
  const auto macs = octets.subspan(kFooterSize);
  if (count * kReceiverMacSize != macs.size()) return fail(Code::secure_group_malformed);
  return CryptoFooter{octets.first(kTagSize), macs};
}

// Reads a CryptoContent: a big-endian length, that many octets, and zeros up to a word.
Result<BytesView> content_from(BytesView body) {
  if (body.size() < 4) return fail(Code::secure_group_malformed);
  const std::uint64_t size = u32_at(body, 0);
  if (padded(size) != body.size() - 4) return fail(Code::secure_group_malformed);
  return body.subspan(4, size);
}

// Flags other than E change the meaning in later versions (P and A of SRTPS_PREFIX).
Status check_flags(const SubmessageHeader& header, std::uint8_t due = 0) {
  if ((header.flags & ~kFlagLittleEndian) != due) return fail(Code::secure_flags_unsupported);
  return {};
}

// Reads the SEC_BODY that fills `octets`.
Result<BytesView> body_from(BytesView octets) {
  if (octets.size() < kSubmessageHeaderSize) return fail(Code::secure_group_malformed);
  const auto header = read_submessage_header(octets);
  if (header.id != submessage_id::kSecBody ||
      header.length != octets.size() - kSubmessageHeaderSize)
    return fail(Code::secure_group_malformed);
  DDSSEC_RETURN_IF_ERROR(check_flags(header));
  return content_from(octets.subspan(kSubmessageHeaderSize));
}

// Returns the position of the postfix: after the SEC_BODY or after the one submessage of a SEC_
// group. In a signed message it is the first postfix id in the chain of submessages.
Result<std::size_t> find_postfix(BytesView octets, Frame frame) {
  std::size_t position = 0;
  while (octets.size() - position >= kSubmessageHeaderSize) {
    const auto header = read_submessage_header(octets.subspan(position));
    if (header.id == frame.postfix) return position;
    position += kSubmessageHeaderSize + header.length;
    if (position > octets.size()) break;
  }
  return fail(Code::secure_group_malformed);
}

// Fast DDS 2.9 appends a statistics submessage (id 0x80) to messages that are already protected.
// It is not authenticated. So everything after the postfix of a message is skipped and lost.
Result<CryptoFooter> postfix_from(BytesView octets, Frame frame) {
  const auto header = read_submessage_header(octets);
  auto content = octets.subspan(kSubmessageHeaderSize);
  const bool may_be_followed = frame.postfix == kMessageFrame.postfix;
  if (may_be_followed && header.length != 0 && header.length < content.size())
    content = content.first(header.length);
  // OpenDDS writes 0, "to the end", where Cyclone and Fast DDS write the length.
  if (header.id != frame.postfix || (header.length != content.size() && header.length != 0))
    return fail(Code::secure_group_malformed);
  DDSSEC_RETURN_IF_ERROR(check_flags(header));
  return footer_from(content);
}

}  // namespace

std::optional<TagView> CryptoFooter::receiver_mac(KeyId id) const {
  for (auto rest = receiver_macs; !rest.empty(); rest = rest.subspan(kReceiverMacSize))
    if (id_at<KeyId>(rest, 0) == id) return TagView(rest.data() + KeyId::size, kTagSize);
  return std::nullopt;
}

Result<ProtectedParts> read_protected_payload(BytesView encoded) {
  constexpr std::size_t kLengthSize = 4;
  // Fast DDS fills the submessage up to whole words after the footer, so the footer is found by the
  // length before the ciphertext. A signed payload has no length: it must be exact.
  constexpr std::size_t kMaxPadding = 3;
  if (encoded.size() < kCryptoHeaderSize + kFooterSize) return fail(Code::secure_group_malformed);
  ProtectedParts out{
      .header = crypto_header_at(encoded), .is_encrypted = false, .content = {}, .footer = {}};
  DDSSEC_ASSIGN_OR_RETURN(out.is_encrypted, encrypts(out.header));
  auto rest = encoded.subspan(kCryptoHeaderSize);
  auto room = rest.size() - kFooterSize, size = room;
  if (out.is_encrypted) {
    if (size < kLengthSize) return fail(Code::secure_group_malformed);
    size = u32_at(rest, 0);
    rest = rest.subspan(kLengthSize);
    room -= kLengthSize;
    if (size > room) return fail(Code::secure_group_malformed);
  }
  const auto footer = rest.subspan(size, kFooterSize);
  // A list of MACs for all readers would not authenticate the origin (DDS-Security 1.2,
  // clause 10.5.3.3.4.4).
  if (u32_at(footer, kTagSize) != 0) return fail(Code::receiver_specific_macs_not_allowed);
  if (room - size > kMaxPadding) return fail(Code::secure_group_malformed);
  DDSSEC_ASSIGN_OR_RETURN(out.footer, footer_from(footer));
  out.content = rest.first(size);
  return out;
}

Result<CryptoHeader> read_prefix(BytesView encoded, Frame frame) {
  if (encoded.size() < kSubmessageHeaderSize + kCryptoHeaderSize)
    return fail(Code::secure_group_malformed);
  const auto header = read_submessage_header(encoded);
  if (header.id != frame.prefix || header.length != kCryptoHeaderSize)
    return fail(Code::secure_group_malformed);
  DDSSEC_RETURN_IF_ERROR(check_flags(header, frame.prefix_flags));
  return crypto_header_at(encoded.subspan(kSubmessageHeaderSize));
}

Result<ProtectedParts> read_protected_group(BytesView encoded, Frame frame) {
  DDSSEC_ASSIGN_OR_RETURN(auto prefix, read_prefix(encoded, frame));
  ProtectedParts out{
      .header = std::move(prefix), .is_encrypted = false, .content = {}, .footer = {}};
  DDSSEC_ASSIGN_OR_RETURN(out.is_encrypted, encrypts(out.header));
  const auto rest = encoded.subspan(kSubmessageHeaderSize + kCryptoHeaderSize);
  DDSSEC_ASSIGN_OR_RETURN(const auto postfix, find_postfix(rest, frame));
  DDSSEC_ASSIGN_OR_RETURN(out.footer, postfix_from(rest.subspan(postfix), frame));
  out.content = rest.first(postfix);
  if (out.is_encrypted) {
    DDSSEC_ASSIGN_OR_RETURN(out.content, body_from(out.content));
  }
  return out;
}

}  // namespace ddssec::cryptography
