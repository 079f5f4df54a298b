// Protects messages, submessages and payloads, and opens protected ones.
#pragma once

#include "plugins/cryptography/crypto_framing.hpp"
#include "plugins/cryptography/cryptography_state.hpp"
#include "plugins/cryptography/sender_part.hpp"

namespace ddssec::cryptography {

/// CryptoTransform (DDS-Security 1.2, clauses 9.5.1.10 and 10.5.3.3).
class Transform final : public spi::CryptoTransform {
 public:
  explicit Transform(CryptographyState& state) : state_(state) {}

  Result<std::size_t> encode_serialized_payload(spi::DatawriterCryptoHandle sender, BytesView plain,
                                                MutableBytes out) override;
  Result<std::size_t> encode_datawriter_submessage(
      spi::DatawriterCryptoHandle sender, std::span<const spi::DatareaderCryptoHandle> receivers,
      BytesView plain, MutableBytes out) override;
  Result<std::size_t> encode_datareader_submessage(
      spi::DatareaderCryptoHandle sender, std::span<const spi::DatawriterCryptoHandle> receivers,
      BytesView plain, MutableBytes out) override;
  Result<std::size_t> encode_rtps_message(spi::ParticipantCryptoHandle sender,
                                          std::span<const spi::ParticipantCryptoHandle> receivers,
                                          BytesView plain, MutableBytes out) override;
  Result<std::size_t> decode_rtps_message(spi::ParticipantCryptoHandle receiver,
                                          spi::ParticipantCryptoHandle sender, BytesView encoded,
                                          MutableBytes out) override;
  Result<spi::SecureSubmessage> preprocess_secure_submessage(spi::ParticipantCryptoHandle receiver,
                                                             spi::ParticipantCryptoHandle sender,
                                                             BytesView encoded) override;
  Result<std::size_t> decode_datawriter_submessage(spi::DatareaderCryptoHandle receiver,
                                                   spi::DatawriterCryptoHandle sender,
                                                   BytesView encoded, MutableBytes out) override;
  Result<std::size_t> decode_datareader_submessage(spi::DatawriterCryptoHandle receiver,
                                                   spi::DatareaderCryptoHandle sender,
                                                   BytesView encoded, MutableBytes out) override;
  Result<std::size_t> decode_serialized_payload(spi::DatareaderCryptoHandle receiver,
                                                spi::DatawriterCryptoHandle sender,
                                                BytesView encoded, MutableBytes out) override;

 private:
  /// Decodes the whole message, including parts that its sender may not send.
  Result<std::size_t> open_message_of(spi::ParticipantCryptoHandle receiver,
                                      spi::ParticipantCryptoHandle sender, BytesView encoded,
                                      MutableBytes out);
  std::size_t keep_part_of_sender(spi::ParticipantCryptoHandle receiver,
                                  spi::ParticipantCryptoHandle sender, MutableBytes message);
  void report_end(spi::ParticipantCryptoHandle receiver, spi::ParticipantCryptoHandle sender,
                  const SenderPart& part, const GuidPrefix& prefix) const;

  CryptographyState& state_;
};

}  // namespace ddssec::cryptography
