// Finds out whether a configuration holds a secret itself.
#pragma once

#include <string_view>

namespace ddssec::governance::doctor {

/// True if `text` holds a private key, or a value for a password that is not the name of a file: in
/// an element or property of a configuration of Cyclone DDS or Fast DDS, or in security.properties.
/// Comments count, too.
bool holds_secret(std::string_view text);

}  // namespace ddssec::governance::doctor
