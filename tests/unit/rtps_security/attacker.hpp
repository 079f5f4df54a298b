// An attacker without keys between two secured participants: it receives everything, and sends in
// any name.
#pragma once

#include <algorithm>
#include <map>
#include <optional>
#include <string>

#include "tests/unit/rtps_security/security_fixture.hpp"
#include "wire/message_reader.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps::testing {

/// Returns an unprotected message in the name of `from`.
template <class... S>
Bytes forged(const GuidPrefix& from, const S&... submessages) {
  Bytes buffer(65536);
  SpanWriter out(buffer);
  Header header;
  header.prefix = from;
  write(out, header);
  (write(out, submessages), ...);
  return to_bytes(out.view());
}

inline Bytes stateless(const GuidPrefix& from, const GenericMessage& message) {
  const auto payload = write_generic_message(message);
  return forged(
      from,
      Data{kStatelessMessageReader, kStatelessMessageWriter, {1}, {}, PayloadKind::data, payload});
}

/// Returns a handshake message of `from` to `to`.
inline Bytes handshake_message(const GuidPrefix& from, const GuidPrefix& to, spi::Token token,
                               std::string_view message_class = message_class::kAuthentication) {
  GenericMessage message;
  message.identity = {{from, kStatelessMessageWriter}, 99};
  message.destination_participant = {to, kEntityIdParticipant};
  message.message_class = message_class;
  message.data = {std::move(token)};
  return stateless(from, message);
}

inline Bytes announcement(const ParticipantData& data) {
  Bytes buffer(4096);
  SpanWriter out(buffer);
  write_payload(out, data);
  return forged(data.guid.prefix,
                Data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, out.view()});
}

inline GuidPrefix fake_prefix(std::uint32_t i) {
  GuidPrefix prefix;
  prefix.octets[0] = static_cast<std::uint8_t>(0x80 | (i & 0x7f));
  for (std::size_t octet = 0; octet < 4; ++octet)
    prefix.octets[octet + 2] = static_cast<std::uint8_t>(i >> (8 * octet));
  return prefix;
}

/// Returns what a secured participant of that name would announce in a domain where nothing is
/// protected.
inline ParticipantData secured_data(const GuidPrefix& prefix, std::uint16_t port = 7999) {
  ParticipantData data;
  data.guid = {prefix, kEntityIdParticipant};
  data.builtin_endpoints = builtin_endpoints::kWithSecurity;
  data.metatraffic_unicast = {*Locator::parse("127.0.0.1", port)};
  data.identity_token = spi::Token{"DDS:Auth:PKI-DH:1.0", {}, {}};
  data.permissions_token = spi::Token{"DDS:Access:Permissions:1.0", {}, {}};
  data.security_info = spi::security_info(spi::ParticipantSecurityAttributes{});
  return data;
}

/// Returns the announcement of a participant that will never prove anything.
inline Bytes fake_announcement(std::uint32_t i) {
  return announcement(secured_data(fake_prefix(i)));
}

/// Calls `f` with each DATA of an unprotected datagram.
template <class F>
void each_data(BytesView datagram, F&& f) {
  auto reader = MessageReader::open(datagram);
  while (reader) {
    const auto view = reader->next();
    if (!view || !*view) return;
    if ((*view)->id != SubmessageId::data) continue;
    if (const auto data = read_data(**view)) f(*data);
  }
}

/// Returns what a participant announces of itself in a datagram.
inline std::optional<ParticipantData> announced_in(BytesView datagram) {
  std::optional<ParticipantData> out;
  each_data(datagram, [&](const Data& data) {
    if (out || data.writer != kSpdpWriter || data.kind != PayloadKind::data) return;
    if (auto announced = read_participant_data(data.payload)) out = *std::move(announced);
  });
  return out;
}

/// Keeps the latest handshake token of each kind that was sent.
class Eavesdropper {
 public:
  void hear(BytesView datagram) {
    each_data(datagram, [&](const Data& data) {
      if (data.writer != kStatelessMessageWriter) return;
      const auto message = read_generic_message(data.payload);
      if (message && message->data.size() == 1) note(message->data.front());
    });
  }
  /// Returns the token of kind "+Req", "+Reply" or "+Final"; nullptr if none was heard yet.
  const spi::Token* heard(std::string_view kind) const {
    const auto at = heard_.find(std::string(kind));
    return at == heard_.end() ? nullptr : &at->second;
  }

 private:
  void note(const spi::Token& token) {
    const auto plus = token.class_id.rfind('+');
    if (plus != std::string::npos) heard_[token.class_id.substr(plus)] = token;
  }
  std::map<std::string, spi::Token> heard_;
};

inline Bytes* field(spi::Token& token, std::string_view name) {
  for (auto& property : token.binary_properties)
    if (property.name == name) return &property.value;
  return nullptr;
}

inline bool know_each_other(Pair& pair) { return pair.a.knows(pair.b) && pair.b.knows(pair.a); }

}  // namespace ddssec::rtps::testing
