// The places where a participant's renewal list may be.
#pragma once

#include <string>
#include <vector>

#include "plugins/spi/token.hpp"

namespace ddssec::spi {

/// Returns the URIs of the file that the property names, or else of renewed.pem beside the identity
/// certificate and beside the identity CA, as far as these are files. None of them need exist.
/// Error: invalid_property (it names no file).
Result<std::vector<std::string>> renewal_list_places(const PropertyList& properties);

}  // namespace ddssec::spi
