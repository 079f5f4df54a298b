// The octets of CryptoHeader, CryptoContent and CryptoFooter (DDS-Security 1.2, clauses 10.5.2.3
// to 10.5.2.5), and of the secure submessages around them (clause 7.4.6). Reading checks
// everything; writing expects checked sizes.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <optional>
#include <utility>

#include "base/ids.hpp"
#include "base/result.hpp"
#include "base/submessage_ids.hpp"
#include "plugins/cryptography/aead.hpp"

namespace ddssec::cryptography {

inline constexpr std::size_t kCryptoHeaderSize = 20;
inline constexpr std::size_t kReceiverMacSize = 20;
inline constexpr std::size_t kFooterSize = 20;  ///< size without receiver-specific MACs
inline constexpr std::size_t kInfoSourceSize = 24;
/// The largest octetsToNextHeader that is a multiple of 4.
inline constexpr std::size_t kMaxSubmessageContent = 65532;
/// The largest number of receivers in a SEC_POSTFIX.
inline constexpr std::size_t kMaxReceivers =
    (kMaxSubmessageContent - kFooterSize) / kReceiverMacSize;

/// The ids as octets, as they are compared with those of a message.
namespace submessage_id {
inline constexpr auto kAckNack = std::to_underlying(SubmessageId::acknack);
inline constexpr auto kHeartbeat = std::to_underlying(SubmessageId::heartbeat);
inline constexpr auto kGap = std::to_underlying(SubmessageId::gap);
inline constexpr auto kInfoTimestamp = std::to_underlying(SubmessageId::info_timestamp);
inline constexpr auto kInfoSource = std::to_underlying(SubmessageId::info_source);
inline constexpr auto kInfoDestination = std::to_underlying(SubmessageId::info_destination);
inline constexpr auto kNackFrag = std::to_underlying(SubmessageId::nack_frag);
inline constexpr auto kHeartbeatFrag = std::to_underlying(SubmessageId::heartbeat_frag);
inline constexpr auto kData = std::to_underlying(SubmessageId::data);
inline constexpr auto kDataFrag = std::to_underlying(SubmessageId::data_frag);
inline constexpr auto kSecBody = std::to_underlying(SubmessageId::secure_body);
inline constexpr auto kSecPrefix = std::to_underlying(SubmessageId::secure_prefix);
inline constexpr auto kSecPostfix = std::to_underlying(SubmessageId::secure_postfix);
inline constexpr auto kSrtpsPrefix = std::to_underlying(SubmessageId::secure_rtps_prefix);
inline constexpr auto kSrtpsPostfix = std::to_underlying(SubmessageId::secure_rtps_postfix);
}  // namespace submessage_id

/// The ids of a prefix and its postfix.
struct Frame {
  std::uint8_t prefix;
  std::uint8_t postfix;
  std::uint8_t prefix_flags = 0;  ///< flags besides E
};
inline constexpr Frame kSubmessageFrame{submessage_id::kSecPrefix, submessage_id::kSecPostfix};
inline constexpr Frame kMessageFrame{submessage_id::kSrtpsPrefix, submessage_id::kSrtpsPostfix};
inline constexpr Frame kPreSharedKeyFrame{submessage_id::kSrtpsPrefix, submessage_id::kSrtpsPostfix,
                                          kFlagPreSharedKey};

/// The fields of a CryptoHeader.
struct CryptoHeader {
  TransformKind kind;
  KeyId key_id;
  SessionId session_id;
  Iv iv;  ///< session id and suffix, as in the header
};

/// The fields of a CryptoFooter; borrowed.
struct CryptoFooter {
  BytesView common_mac;     ///< kTagSize octets
  BytesView receiver_macs;  ///< a multiple of kReceiverMacSize

  TagView tag() const { return TagView(common_mac.data(), kTagSize); }
  /// Returns the MAC for a receiver-specific key; empty if there is none.
  std::optional<TagView> receiver_mac(KeyId id) const;
};

/// A protected message or payload, taken apart; borrowed.
struct ProtectedParts {
  CryptoHeader header;
  bool is_encrypted;  ///< the content came as CryptoContent
  BytesView content;  ///< ciphertext, or the signed octets
  CryptoFooter footer;
};

/// Reads a protected payload. The kind decides whether it has a CryptoContent. Errors:
/// secure_group_malformed, receiver_specific_macs_not_allowed, crypto_header_kind_unknown.
Result<ProtectedParts> read_protected_payload(BytesView encoded);
/// Reads a whole SEC_ group, or the part of an RTPS message after its header. Errors:
/// secure_group_malformed, secure_flags_unsupported, crypto_header_kind_unknown.
Result<ProtectedParts> read_protected_group(BytesView encoded, Frame frame);
/// Reads the CryptoHeader of a SEC_ group, whatever follows. Errors as above.
Result<CryptoHeader> read_prefix(BytesView encoded, Frame frame);

/// One submessage header.
struct SubmessageHeader {
  std::uint8_t id;
  std::uint8_t flags;
  std::size_t length;  ///< octetsToNextHeader, unchanged
};
/// Reads a submessage header. The caller has checked that there are at least 4 octets.
inline SubmessageHeader read_submessage_header(BytesView octets) {
  const bool little = (octets[1] & kFlagLittleEndian) != 0;
  const std::size_t length = little ? octets[2] | octets[3] << 8 : octets[2] << 8 | octets[3];
  return {octets[0], octets[1], length};
}

/// Returns the size of the first submessage in octets, including its header, as Cyclone DDS reads
/// it; empty if Cyclone DDS stops reading there. Length 0 means "to the end" (RTPS 9.4.5.1.3). For
/// INFO_TS and PAD it means empty, and more submessages can follow.
inline std::optional<std::size_t> size_of_first_submessage(BytesView octets) {
  constexpr std::uint8_t kPad = 0x01;
  if (octets.size() < kSubmessageHeaderSize) return std::nullopt;
  const auto header = read_submessage_header(octets);
  if (header.length == 0) {
    const bool is_empty = header.id == kPad || header.id == submessage_id::kInfoTimestamp;
    return is_empty ? kSubmessageHeaderSize : octets.size();
  }
  const auto size = kSubmessageHeaderSize + header.length;
  if (size > octets.size()) return std::nullopt;
  if (header.length % 4 != 0 && size != octets.size()) return std::nullopt;
  return size;
}

/// Returns the number in big-endian byte order.
template <class T>
T big_endian(T value) {
  return std::endian::native == std::endian::little ? std::byteswap(value) : value;
}

/// Writes into a buffer whose size the caller has checked. It is inline and writes a word at a
/// time: octet by octet, the framing of a 64-octet message would take longer than its encryption.
class UncheckedWriter {
 public:
  explicit UncheckedWriter(MutableBytes out) : begin_(out.data()), at_(out.data()) {}
  void put(BytesView octets) {
    if (!octets.empty()) std::memcpy(at_, octets.data(), octets.size());
    at_ += octets.size();
  }
  template <std::size_t N>
  void put(const std::array<std::uint8_t, N>& octets) {
    std::memcpy(skip(N), octets.data(), N);
  }
  void u32(std::uint32_t value) {
    const auto octets = big_endian(value);
    std::memcpy(skip(sizeof octets), &octets, sizeof octets);
  }
  void crypto_header(TransformKind kind, KeyId key, const Iv& iv) {
    put(kind.octets);
    put(key.octets);
    put(iv);
  }
  /// Writes a little-endian header, in which flag E is 1.
  void submessage_header(std::uint8_t id, std::size_t length, std::uint8_t flags = 0) {
    u32(static_cast<std::uint32_t>(id) << 24 |
        static_cast<std::uint32_t>(flags | kFlagLittleEndian) << 16 |
        std::byteswap(static_cast<std::uint16_t>(length)));
  }
  void zeros(std::size_t count) { std::fill_n(skip(count), count, std::uint8_t{0}); }
  /// Skips `count` octets and returns their position, to be written later.
  std::uint8_t* skip(std::size_t count) { return std::exchange(at_, at_ + count); }
  std::size_t written() const { return static_cast<std::size_t>(at_ - begin_); }

 private:
  std::uint8_t* begin_;
  std::uint8_t* at_;
};

constexpr std::size_t padded(std::size_t size) { return (size + 3) & ~std::size_t{3}; }

}  // namespace ddssec::cryptography
