// Properties of a participant that the host cannot pass: Cyclone's core passes no participant
// properties to the cryptography plugin, and its configuration file accepts only known names.
#pragma once

#include "base/result.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::cyclonedds {

/// The value of dds.sec.crypto.symmetric_cipher_algorithm; takes precedence over the file.
inline constexpr const char* kCipherVariable = "DDSSEC_SYMMETRIC_CIPHER_ALGORITHM";
/// The path of a properties file.
inline constexpr const char* kPropertiesVariable = "DDSSEC_PROPERTIES";

/// The properties from the host, completed by those from the two environment variables where the
/// host names none. An empty value of the host and an empty variable count as none. Errors: those
/// of spi::read_property_file, and property_without_effect for a property that Cyclone DDS cannot
/// support.
Result<spi::PropertyList> with_process_properties(spi::PropertyList of_host);

}  // namespace ddssec::cyclonedds
