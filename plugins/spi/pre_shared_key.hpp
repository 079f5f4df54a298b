// Protection of whole RTPS messages by a key that all participants of a domain share (DDS-Security
// 1.2 8.5.1.9, encode_rtps_message with transform_with_psk).
#pragma once

#include <string_view>

#include "base/bytes.hpp"
#include "base/ids.hpp"
#include "plugins/spi/attributes.hpp"

namespace ddssec::spi {

/// What the keys are made from. Borrowed for the call.
struct PreSharedKeyRequest {
  const PropertyList& properties;
  /// rtps_psk: sign or encrypt.
  const ParticipantSecurityAttributes& attributes;
  DomainId domain_id;
  std::string_view domain_tag;
};

/// The pre-shared keys of one local participant. A holder of the passphrase belongs to the domain,
/// in whatever name: this hides and protects what is said before participants have authenticated
/// each other, and proves nothing about who said it. Not thread-safe. Buffers as of
/// CryptoTransform's RTPS pair.
class PreSharedKeys {
 public:
  virtual ~PreSharedKeys() = default;

  /// Under the first passphrase. Errors: plaintext_malformed, length_out_of_range,
  /// session_ids_exhausted.
  virtual Result<std::size_t> encode(BytesView plain, MutableBytes out) = 0;
  /// False: its sender was not heard yet, and to open it costs a derivation of keys, which any
  /// sender can demand.
  virtual bool remembers(BytesView encoded) const = 0;
  /// Under any passphrase, as the message says. Errors: psk_passphrase_unknown, those of
  /// CryptoTransform::decode_rtps_message.
  virtual Result<std::size_t> decode(BytesView encoded, MutableBytes out) = 0;
  /// Reads the passphrases again if their files may have changed; to be called every second or so.
  /// Events: psk_passphrases_changed; psk_passphrases_kept, if they cannot be used: then nothing
  /// changes.
  virtual void refresh() = 0;
};

/// Does a message say that it is protected so? Flag P of an SRTPS_PREFIX behind the RTPS header.
constexpr bool has_pre_shared_key_flag(BytesView message) {
  return message.size() > 21 && message[20] == 0x33 && (message[21] & 0x04) != 0;
}

}  // namespace ddssec::spi
