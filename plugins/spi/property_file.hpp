// A file of properties: what a host has no other way to say (security.properties).
#pragma once

#include <filesystem>
#include <string_view>

#include "base/result.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

inline constexpr std::size_t kMostPropertyFileOctets = 64 * 1024;
inline constexpr std::size_t kMostPropertiesPerFile = 256;

/// One `name = value` a line; blanks around both are dropped, empty lines and those that begin with
/// # are passed over. None propagates. Errors: invalid_property with the line (no name, no =, a
/// name twice, a control character, too many).
Result<PropertyList> parse_properties(std::string_view text);

/// The properties of a file. Errors: those, and file_not_found, file_unreadable, file_too_large.
Result<PropertyList> read_property_file(const std::filesystem::path& path);

}  // namespace ddssec::spi
