// Key token messages, as the volatile secure writer sends them.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "plugins/spi/token.hpp"
#include "tests/unit/cryptography/data_message.hpp"
#include "tests/unit/cryptography/insider.hpp"

namespace ddssec::cryptography::testing {

inline constexpr GuidPrefix kOurs{{0x90, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}};
inline constexpr std::string_view kOfParticipant = "dds.sec.participant_crypto_tokens";
inline constexpr std::string_view kOfWriter = "dds.sec.datawriter_crypto_tokens";

/// Returns tokens that differ from all before.
inline std::vector<spi::Token> fresh_tokens() {
  static std::uint8_t number = 0;
  auto token = Insider(kAes256Gcm).token();
  token.binary_properties.at(0).value.back() = ++number;
  return {token};
}

inline void append_guid(Bytes& out, const Guid& guid) { append(out, guid.octets()); }

/// Returns a ParticipantGenericMessage with key tokens.
inline Bytes token_message(const Guid& remote, const Guid& local,
                           std::span<const spi::Token> tokens,
                           std::string_view class_id = kOfWriter, bool little = true) {
  const bool of_participant = class_id == kOfParticipant;
  Writer writer(little ? Endian::little : Endian::big);
  Bytes begin;
  append_guid(begin, {remote.prefix, {}});
  begin.resize(48, 0);
  append_guid(begin, {local.prefix, kEntityIdParticipant});
  append_guid(begin, of_participant ? Guid{} : local);
  append_guid(begin, of_participant ? Guid{} : remote);
  writer.write_bytes(begin);
  writer.write_string(class_id);
  writer.write_aligned(static_cast<std::uint32_t>(tokens.size()));
  for (const auto& one : tokens) spi::write_token(writer, one);
  Bytes out = {0, static_cast<std::uint8_t>(little ? 1 : 0), 0, 0};
  append(out, writer.take());
  out.resize(padded(out.size()));
  return out;
}

}  // namespace ddssec::cryptography::testing
