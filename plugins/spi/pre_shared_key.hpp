// Protection of whole RTPS messages by a key that all participants of a domain share (DDS-Security
// 1.2, clause 9.5.1.10, encode_rtps_message with transform_with_psk).
#pragma once

#include <cstddef>
#include <string_view>
#include <utility>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "base/submessage_ids.hpp"
#include "plugins/spi/attributes.hpp"

namespace ddssec::spi {

/// The inputs from which the keys are derived. Borrowed for the call.
struct PreSharedKeyRequest {
  const PropertyList& properties;
  /// The attributes of the participant. Only rtps_psk (sign or encrypt) and allowed_ciphers count.
  const ParticipantSecurityAttributes& attributes;
  DomainId domain_id;
  std::string_view domain_tag;
};

/// The pre-shared keys of one local participant. Any holder of the passphrase counts as a member of
/// the domain, under any name. So these keys hide and protect messages sent before participants
/// have authenticated each other, but prove nothing about the sender. Not thread-safe. Buffers
/// follow the rules of the RTPS pair of CryptoTransform.
class PreSharedKeys {
 public:
  virtual ~PreSharedKeys() = default;

  /// Encodes one RTPS message under the first passphrase and returns the octets written. Errors:
  /// plaintext_malformed, length_out_of_range, session_ids_exhausted, random_failed, internal.
  virtual Result<std::size_t> encode(BytesView plain, MutableBytes out) = 0;
  /// True if the keys of the sender are already derived. If false, decoding costs a key derivation,
  /// which any sender can cause.
  virtual bool remembers(BytesView encoded) const = 0;
  /// Decodes one RTPS message under the passphrase that it names and returns the octets written.
  /// Errors: psk_passphrase_unknown, those of CryptoTransform::decode_rtps_message.
  virtual Result<std::size_t> decode(BytesView encoded, MutableBytes out) = 0;
  /// Reads the passphrases again if their files may have changed. Call it about once a second.
  /// Events: psk_passphrases_changed; psk_passphrases_kept if the new ones cannot be used, so that
  /// the former ones stay in use.
  virtual void refresh() = 0;
};

/// True if the message claims this protection: flag P of an SRTPS_PREFIX directly after the RTPS
/// header.
constexpr bool has_pre_shared_key_flag(BytesView message) {
  return message.size() > kRtpsHeaderSize + 1 &&
         message[kRtpsHeaderSize] == std::to_underlying(SubmessageId::secure_rtps_prefix) &&
         (message[kRtpsHeaderSize + 1] & kFlagPreSharedKey) != 0;
}

}  // namespace ddssec::spi
