// Parameters that only secured participants and endpoints announce (DDS-Security 1.2,
// clause 7.5.1), and keys of builtin topics.
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/token.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::rtps {

/// Reads the value of a token parameter. Errors: those of spi::read_token.
Status read_token_into(Reader& reader, std::optional<spi::Token>& token);
/// Writes the parameter, or nothing if there is no token.
void write_token(SpanWriter& out, ParameterId id, const std::optional<spi::Token>& token);
/// Reads the 8-octet form, and the 12-octet form of DDS-Security 1.2. Only the 8-octet form is
/// written, because all peers can read it. Error: truncated.
Status read_security_info_into(Reader& reader, std::optional<spi::SecurityInfo>& info);
/// Writes the parameter in the 8-octet form, or nothing if there is no info.
void write_security_info(SpanWriter& out, ParameterId id,
                         const std::optional<spi::SecurityInfo>& info);

/// Reads the symmetric cipher algorithm info of a participant. Error: truncated.
Status read_ciphers_into(Reader& reader, std::optional<spi::SymmetricCipherInfo>& info);
/// Reads that of an endpoint, which has only the required ciphers. Error: truncated.
Status read_ciphers_into(Reader& reader, std::optional<spi::CipherMask>& required);
/// Each writes the parameter, or nothing if there is no value.
void write_ciphers(SpanWriter& out, const std::optional<spi::SymmetricCipherInfo>& info);
void write_ciphers(SpanWriter& out, const std::optional<spi::CipherMask>& required);

/// Reads a PL_CDR payload with one GUID, the key of a builtin topic's instance. Errors: those of
/// open_pl_cdr and ParameterReader, rtps_parameter_missing.
Result<Guid> read_guid_key(BytesView payload, ParameterId id);
/// Writes such a payload, with encapsulation.
void write_guid_key(SpanWriter& out, ParameterId id, const Guid& guid);

}  // namespace ddssec::rtps
