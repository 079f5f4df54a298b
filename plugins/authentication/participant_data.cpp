#include "plugins/authentication/participant_data.hpp"

#include <optional>

#include "base/reader.hpp"
#include "plugins/authentication/identity_token.hpp"

namespace ddssec::authentication {
namespace {

constexpr std::uint16_t kPidSentinel = 0x0001;
constexpr std::uint16_t kPidParticipantGuid = 0x0050;
constexpr std::uint16_t kPidIdentityToken = 0x1001;

std::unexpected<Error> malformed(std::string found) {
  return fail(Code::participant_data_malformed, {.field = "c.pdata", .found = std::move(found)});
}

struct Parameter {
  std::uint16_t id;
  BytesView value;
};

/// The next parameter, or nothing at the end.
Result<std::optional<Parameter>> next_parameter(Reader& reader) {
  if (reader.at_end()) return std::nullopt;
  const auto id = reader.read<std::uint16_t>();
  const auto length = reader.read<std::uint16_t>();
  if (!id || !length) return malformed("half a parameter header");
  if (*id == kPidSentinel) return std::nullopt;
  const auto value = reader.read_bytes(*length);
  if (!value) return malformed("a parameter longer than the list");
  return Parameter{*id, *value};
}

Guid guid_from(BytesView octets) {
  return {GuidPrefix::from(octets.first(12)), EntityId::from(octets.subspan(12, 4))};
}

}  // namespace

Result<Guid> participant_guid_in(BytesView participant_data) {
  Reader reader(participant_data, Endian::big);
  std::optional<Guid> found;
  while (const auto parameter = DDSSEC_TRY(next_parameter(reader))) {
    if (parameter->id != kPidParticipantGuid) continue;
    if (parameter->value.size() < 16) return malformed("a short PARTICIPANT_GUID");
    const Guid guid = guid_from(parameter->value);
    if (found && *found != guid) return malformed("two different PARTICIPANT_GUIDs");
    found = guid;
  }
  if (!found) return fail(Code::participant_guid_missing, {.field = "c.pdata"});
  return *found;
}

spi::CipherMask ciphers_in_participant_data(BytesView participant_data) {
  Reader reader(participant_data, Endian::big);
  std::optional<spi::Token> found;
  for (;;) {
    const auto parameter = next_parameter(reader);
    if (!parameter || !*parameter) break;
    if ((*parameter)->id != kPidIdentityToken) continue;
    Reader value((*parameter)->value, Endian::big);
    auto token = spi::read_token(value);
    if (!token || found) return spi::kStandardCiphers;
    found = std::move(*token);
  }
  return found ? announced_ciphers(*found) : spi::kStandardCiphers;
}

}  // namespace ddssec::authentication
