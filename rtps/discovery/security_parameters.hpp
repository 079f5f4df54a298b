// Parameters that only secured participants and endpoints announce (DDS-Security 1.2,
// clause 7.5.1), and keys of builtin topics.
#pragma once

#include <optional>

#include "base/ids.hpp"
#include "plugins/spi/attributes.hpp"
#include "plugins/spi/token.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::rtps {

Status read_token_into(Reader& reader, std::optional<spi::Token>& token);
void write_token(SpanWriter& out, ParameterId id, const std::optional<spi::Token>& token);
/// Reads the 8-octet form, and the 12-octet form of DDS-Security 1.2. Only the 8-octet form is
/// written, because all peers can read it.
Status read_security_info_into(Reader& reader, std::optional<spi::SecurityInfo>& info);
void write_security_info(SpanWriter& out, ParameterId id,
                         const std::optional<spi::SecurityInfo>& info);

/// Read and write the symmetric cipher algorithm info of a participant, or that of an endpoint,
/// which has only the required ciphers.
Status read_ciphers_into(Reader& reader, std::optional<spi::SymmetricCipherInfo>& info);
Status read_ciphers_into(Reader& reader, std::optional<spi::CipherMask>& required);
void write_ciphers(SpanWriter& out, const std::optional<spi::SymmetricCipherInfo>& info);
void write_ciphers(SpanWriter& out, const std::optional<spi::CipherMask>& required);

/// Reads a PL_CDR payload with one GUID, the key of a builtin topic's instance. Errors: those of
/// ParameterReader, rtps_parameter_missing.
Result<Guid> read_guid_key(BytesView payload, ParameterId id);
void write_guid_key(SpanWriter& out, ParameterId id, const Guid& guid);

}  // namespace ddssec::rtps
