// Properties of a participant that Cyclone DDS cannot pass: its core passes no participant
// properties to the cryptography plugin, and its configuration file accepts only known names. They
// are read here, because `ddssec doctor` judges them as the plugins do.
#pragma once

#include "base/result.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// The variable with the value of dds.sec.crypto.symmetric_cipher_algorithm. It takes precedence
/// over the file.
inline constexpr const char* kCipherVariable = "DDSSEC_SYMMETRIC_CIPHER_ALGORITHM";
/// The variable with the path of a properties file.
inline constexpr const char* kPropertiesVariable = "DDSSEC_PROPERTIES";

/// Returns the properties from the host, completed by those from the two environment variables for
/// names that the host does not set. An empty value of the host and an empty variable count as not
/// set. Errors: those of read_property_file, and property_without_effect for a property that
/// Cyclone DDS cannot support.
Result<PropertyList> with_process_properties(PropertyList of_host);

/// Success if the values that the adapters to Cyclone DDS read themselves are good. The plugins
/// read others. Error: invalid_property.
Status check_properties_of_adapters(const PropertyList& properties);

}  // namespace ddssec::spi
