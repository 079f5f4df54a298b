#include "rtps/discovery/security_parameters.hpp"

#include "rtps/discovery/parameter_table.hpp"
#include "wire/submessage.hpp"

namespace ddssec::rtps {

Status read_token_into(Reader& reader, std::optional<spi::Token>& token) {
  DDSSEC_ASSIGN_OR_RETURN(token, spi::read_token(reader));
  return {};
}

void write_token(SpanWriter& out, ParameterId id, const std::optional<spi::Token>& token) {
  if (!token) return;
  Writer octets(out.endian());
  spi::write_token(octets, *token);
  const ParameterScope scope(out, id);
  out.write_bytes(octets.view());
}

Status read_security_info_into(Reader& reader, std::optional<spi::SecurityInfo>& info) {
  DDSSEC_ASSIGN_OR_RETURN(const auto mask, reader.read<std::uint32_t>());
  DDSSEC_ASSIGN_OR_RETURN(const auto plugin_mask, reader.read<std::uint32_t>());
  info = spi::SecurityInfo{mask, plugin_mask};
  return {};
}

void write_security_info(SpanWriter& out, ParameterId id,
                         const std::optional<spi::SecurityInfo>& info) {
  if (!info) return;
  const ParameterScope scope(out, id);
  out.write(info->mask);
  out.write(info->plugin_mask);
}

Status read_ciphers_into(Reader& reader, std::optional<spi::SymmetricCipherInfo>& info) {
  spi::SymmetricCipherInfo read;
  for (auto* mask : {&read.supported, &read.builtin_required, &read.key_exchange_required,
                     &read.user_default_required}) {
    DDSSEC_ASSIGN_OR_RETURN(*mask, reader.read<std::uint32_t>());
  }
  info = read;
  return {};
}

Status read_ciphers_into(Reader& reader, std::optional<spi::CipherMask>& required) {
  DDSSEC_ASSIGN_OR_RETURN(required, reader.read<std::uint32_t>());
  return {};
}

void write_ciphers(SpanWriter& out, const std::optional<spi::SymmetricCipherInfo>& info) {
  if (!info) return;
  const ParameterScope scope(out, pid::kParticipantCiphers);
  for (const auto mask : {info->supported, info->builtin_required, info->key_exchange_required,
                          info->user_default_required})
    out.write(mask);
}

void write_ciphers(SpanWriter& out, const std::optional<spi::CipherMask>& required) {
  if (!required) return;
  const ParameterScope scope(out, pid::kEndpointCiphers);
  out.write(*required);
}

Result<Guid> read_guid_key(BytesView payload, ParameterId id) {
  DDSSEC_ASSIGN_OR_RETURN(const auto opened, open_pl_cdr(payload));
  ParameterReader parameters(opened.body, opened.endian);
  SingleParameters single;
  std::optional<Guid> found;
  for (;;) {
    const auto parameter = parameters.next();
    if (!parameter && !found) return std::unexpected(parameter.error());
    if (!parameter || !*parameter) break;  // a key may lack its sentinel
    if ((*parameter)->id != id) continue;
    DDSSEC_RETURN_IF_ERROR(single.note(0));
    auto reader = (*parameter)->reader();
    DDSSEC_ASSIGN_OR_RETURN(found, read_guid(reader));
  }
  if (!found) return fail(Code::rtps_parameter_missing);
  return *found;
}

void write_guid_key(SpanWriter& out, ParameterId id, const Guid& guid) {
  write_pl_cdr_encapsulation(out);
  {
    const ParameterScope scope(out, id);
    out.write_bytes(guid.octets());
  }
  write_sentinel(out);
}

}  // namespace ddssec::rtps
