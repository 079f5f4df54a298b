// Two plugins that authenticated each other, for tests: participants, endpoints and their tokens.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/event.hpp"
#include "base/plugin_services.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "tests/support/code_of.hpp"
#include "tests/support/recorded_events.hpp"

namespace ddssec::cryptography::testing {

using spi::DatareaderCryptoHandle;
using spi::DatawriterCryptoHandle;
using spi::EndpointSecurityAttributes;
using spi::IdentityHandle;
using spi::KeyStage;
using spi::ParticipantCryptoHandle;
using spi::ParticipantSecurityAttributes;
using spi::PropertyList;
using spi::ProtectionKind;
using test::code_of;
using Tokens = std::vector<spi::Token>;

inline ParticipantSecurityAttributes participant_attributes(ProtectionKind rtps,
                                                            bool revises_keys = false) {
  ParticipantSecurityAttributes attributes;
  attributes.rtps = rtps;
  attributes.is_key_revision_enabled = revises_keys;
  return attributes;
}

inline EndpointSecurityAttributes endpoint_attributes(ProtectionKind submessage,
                                                      ProtectionKind payload) {
  EndpointSecurityAttributes attributes;
  attributes.submessage = submessage;
  attributes.payload = payload;
  return attributes;
}

/// Returns a secret that is shared with a peer which understands `peer_ciphers`.
inline spi::SharedSecret shared_secret(std::uint8_t seed = 1,
                                       spi::CipherMask peer_ciphers = spi::kAllCiphers) {
  spi::SharedSecret shared;
  shared.secret = spi::SharedSecretOctets::copy_of(Bytes(32, seed)).value();
  shared.challenge1.fill(static_cast<std::uint8_t>(seed + 1));
  shared.challenge2.fill(static_cast<std::uint8_t>(seed + 2));
  shared.peer_ciphers = peer_ciphers;
  return shared;
}

inline PropertyList key_size(std::string_view bits) {
  return {{"dds.sec.crypto.keysize", std::string(bits)}};
}
/// Returns the property that selects an algorithm by its name, and with `messages` the one for a
/// participant's messages.
inline PropertyList cipher(std::string_view name, bool messages = false) {
  PropertyList out = {{"dds.sec.crypto.symmetric_cipher_algorithm", std::string(name)}};
  if (messages)
    out.push_back({"org.ddssec.crypto.message_symmetric_cipher_algorithm", std::string(name)});
  return out;
}
inline PropertyList builtin_endpoint(std::string_view name) {
  return {{"dds.sec.builtin_endpoint_name", std::string(name)}};
}
inline constexpr std::string_view kVolatileWriter = "BuiltinParticipantVolatileMessageSecureWriter";
inline constexpr std::string_view kVolatileReader = "BuiltinParticipantVolatileMessageSecureReader";

/// One plugin, with its services and events.
struct Side {
  explicit Side(const CryptographyOptions& options = {})
      : services{clock, random, events}, plugin(make_cryptography(services, options)) {}
  spi::CryptoKeyFactory& factory() { return plugin->key_factory(); }
  spi::CryptoKeyExchange& exchange() { return plugin->key_exchange(); }
  spi::CryptoTransform& transform() { return plugin->transform(); }

  ManualClock clock{WallTime{}};
  SystemRandom random;
  test::RecordedEvents events;
  PluginServices services;
  std::unique_ptr<spi::Cryptography> plugin;
  ParticipantCryptoHandle participant;
  ParticipantCryptoHandle remote;  ///< the other side's participant, as it is matched here
};

struct WriterToReader {
  DatawriterCryptoHandle writer;         ///< at the sender
  DatareaderCryptoHandle remote_reader;  ///< the reader, as matched by the writer
  DatareaderCryptoHandle reader;         ///< at the receiver
  DatawriterCryptoHandle remote_writer;  ///< the writer, as matched by the reader
};

/// `a` writes, `b` reads.
struct TwoSides {
  explicit TwoSides(ProtectionKind rtps = ProtectionKind::none, const PropertyList& properties = {},
                    const CryptographyOptions& options = {})
      : TwoSides(participant_attributes(rtps), properties, options) {}
  explicit TwoSides(const ParticipantSecurityAttributes& attributes,
                    const PropertyList& properties = {}, const CryptographyOptions& options = {})
      : a(options), b(options) {
    for (auto* side : {&a, &b})
      side->participant =
          side->factory().register_local_participant({1}, {1}, properties, attributes).value();
    match(a);
    match(b);
    exchange_participant_tokens();
  }

  static void match(Side& side, std::uint8_t seed = 1) {
    side.remote =
        side.factory()
            .register_matched_remote_participant(side.participant, {7}, {7}, shared_secret(seed))
            .value();
  }

  void exchange_participant_tokens() {
    const auto pass = [](Side& from, Side& to) {
      const auto tokens =
          from.exchange().create_local_participant_crypto_tokens(from.participant, from.remote);
      return to.exchange().set_remote_participant_crypto_tokens(to.participant, to.remote, *tokens);
    };
    pass(a, b).value();
    pass(b, a).value();
  }

  WriterToReader endpoints(const EndpointSecurityAttributes& attributes,
                           const PropertyList& writer_properties = {},
                           const PropertyList& reader_properties = {}) {
    WriterToReader out;
    out.writer =
        a.factory().register_local_datawriter(a.participant, writer_properties, attributes).value();
    out.reader =
        b.factory().register_local_datareader(b.participant, reader_properties, attributes).value();
    match_endpoints(out);
    return out;
  }

  /// Matches the endpoints, and passes tokens in both directions.
  void match_endpoints(WriterToReader& out) {
    out.remote_reader =
        a.factory()
            .register_matched_remote_datareader(out.writer, a.remote, shared_secret(), false)
            .value();
    out.remote_writer =
        b.factory()
            .register_matched_remote_datawriter(out.reader, b.remote, shared_secret())
            .value();
    const auto of_writer = writer_tokens(out).value(), of_reader = reader_tokens(out).value();
    if (!of_writer.empty()) take_writer(out, of_writer).value();
    if (!of_reader.empty()) take_reader(out, of_reader).value();
  }

  /// The tokens that `a` makes for its participant and its writers, and `b` for its readers, and
  /// the calls in which the other side takes them.
  Result<Tokens> participant_tokens(KeyStage stage = KeyStage::in_use) {
    return a.exchange().create_local_participant_crypto_tokens(a.participant, a.remote, stage);
  }
  Result<Tokens> writer_tokens(const WriterToReader& e, KeyStage stage = KeyStage::in_use) {
    return a.exchange().create_local_datawriter_crypto_tokens(e.writer, e.remote_reader, stage);
  }
  Result<Tokens> reader_tokens(const WriterToReader& e, KeyStage stage = KeyStage::in_use) {
    return b.exchange().create_local_datareader_crypto_tokens(e.reader, e.remote_writer, stage);
  }
  Status take_participant(std::span<const spi::Token> tokens) {
    return b.exchange().set_remote_participant_crypto_tokens(b.participant, b.remote, tokens);
  }
  Status take_writer(const WriterToReader& e, std::span<const spi::Token> tokens) {
    return b.exchange().set_remote_datawriter_crypto_tokens(e.reader, e.remote_writer, tokens);
  }
  Status take_reader(const WriterToReader& e, std::span<const spi::Token> tokens) {
    return a.exchange().set_remote_datareader_crypto_tokens(e.writer, e.remote_reader, tokens);
  }

  WriterToReader volatile_endpoints() {
    const auto out = silent_volatile_endpoints();
    let_reader_speak(b, out.reader, out.remote_writer);
    return out;
  }
  /// Returns volatile endpoints whose reader the host has not connected yet.
  WriterToReader silent_volatile_endpoints() {
    return endpoints(endpoint_attributes(ProtectionKind::encrypt, ProtectionKind::none),
                     builtin_endpoint(kVolatileWriter), builtin_endpoint(kVolatileReader));
  }
  /// The reader sends a submessage that acknowledges nothing.
  static void let_reader_speak(Side& side, spi::DatareaderCryptoHandle reader,
                               spi::DatawriterCryptoHandle to) {
    constexpr std::array<std::uint8_t, 8> kPad = {0x01, 0x01, 4, 0};
    std::array<std::uint8_t, 256> out;
    side.transform().encode_datareader_submessage(reader, {&to, 1}, kPad, out).value();
  }

  Side a;
  Side b;
};

/// Returns what an encoder or decoder writes, as octets of its own.
inline Result<Bytes> into_bytes(std::size_t room,
                                const std::function<Result<std::size_t>(MutableBytes)>& call) {
  Bytes out(room);
  auto size = call(out);
  if (!size) return std::unexpected(std::move(size).error());
  out.resize(*size);
  return out;
}

inline Result<Bytes> encode_payload(TwoSides& two, const WriterToReader& e, BytesView plain) {
  return into_bytes(plain.size() + spi::protection_overhead(0), [&](MutableBytes out) {
    return two.a.transform().encode_serialized_payload(e.writer, plain, out);
  });
}
inline Result<Bytes> decode_payload(TwoSides& two, const WriterToReader& e, BytesView encoded) {
  return into_bytes(encoded.size(), [&](MutableBytes out) {
    return two.b.transform().decode_serialized_payload(e.reader, e.remote_writer, encoded, out);
  });
}
inline Result<Bytes> encode_submessage(TwoSides& two, const WriterToReader& e, BytesView plain) {
  return into_bytes(plain.size() + spi::protection_overhead(1), [&](MutableBytes out) {
    return two.a.transform().encode_datawriter_submessage(e.writer, {&e.remote_reader, 1}, plain,
                                                          out);
  });
}
inline Result<Bytes> decode_submessage(TwoSides& two, const WriterToReader& e, BytesView encoded) {
  return into_bytes(encoded.size(), [&](MutableBytes out) {
    return two.b.transform().decode_datawriter_submessage(e.reader, e.remote_writer, encoded, out);
  });
}
/// Encodes a submessage of the reader; decode_reply() is the writer's side.
inline Result<Bytes> encode_reply(TwoSides& two, const WriterToReader& e, BytesView plain) {
  return into_bytes(plain.size() + spi::protection_overhead(1), [&](MutableBytes out) {
    return two.b.transform().encode_datareader_submessage(e.reader, {&e.remote_writer, 1}, plain,
                                                          out);
  });
}
inline Result<Bytes> decode_reply(TwoSides& two, const WriterToReader& e, BytesView encoded) {
  return into_bytes(encoded.size(), [&](MutableBytes out) {
    return two.a.transform().decode_datareader_submessage(e.writer, e.remote_reader, encoded, out);
  });
}
inline Result<Bytes> encode_message(TwoSides& two, BytesView plain) {
  return into_bytes(plain.size() + spi::protection_overhead(1), [&](MutableBytes out) {
    return two.a.transform().encode_rtps_message(two.a.participant, {&two.a.remote, 1}, plain, out);
  });
}
inline Result<Bytes> decode_message(TwoSides& two, BytesView encoded) {
  return into_bytes(encoded.size(), [&](MutableBytes out) {
    return two.b.transform().decode_rtps_message(two.b.participant, two.b.remote, encoded, out);
  });
}

/// Returns DATA with `size` octets after its header (a multiple of 4).
inline Bytes data_submessage(std::size_t size, std::uint8_t id = 0x15) {
  Bytes out(4 + size, 0x5a);
  out[0] = id, out[1] = 0x05;
  out[2] = static_cast<std::uint8_t>(size), out[3] = static_cast<std::uint8_t>(size >> 8);
  return out;
}

inline Bytes rtps_message(std::initializer_list<Bytes> submessages) {
  Bytes out = to_bytes(as_bytes("RTPS"));
  for (std::uint8_t octet : {2, 3, 1, 16, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12})
    out.push_back(octet);
  for (const auto& one : submessages) out.insert(out.end(), one.begin(), one.end());
  return out;
}

/// True also for a repeated message: a thread may sleep between encoding and decoding while the
/// others fill the replay window.
inline bool is_decoded_or_late(const Result<Bytes>& decoded) {
  return decoded || decoded.error().code() == Code::message_repeated;
}

}  // namespace ddssec::cryptography::testing
