// What a participant is told where the host tells it nothing: Cyclone's core passes no participant
// properties to the cryptography plugin, and its configuration file knows only its own names.
#pragma once

#include "base/result.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cyclonedds {

/// The value of dds.sec.crypto.symmetric_cipher_algorithm; goes before the file.
inline constexpr const char* kCipherVariable = "DDSSEC_SYMMETRIC_CIPHER_ALGORITHM";
/// The path of a file of properties.
inline constexpr const char* kPropertiesVariable = "DDSSEC_PROPERTIES";

/// What the host says, and what the two environment variables say where the host names nothing; an
/// empty value of the host and an empty variable name nothing. Errors: those of
/// spi::read_property_file, and property_without_effect for what Cyclone DDS cannot honour.
Result<spi::PropertyList> with_process_properties(spi::PropertyList of_host);

}  // namespace ddssec::cyclonedds
