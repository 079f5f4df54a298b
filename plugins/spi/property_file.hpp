// A file of properties: what a host has no other way to say (security.properties).
#pragma once

#include <filesystem>
#include <string_view>

#include "base/result.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

inline constexpr std::size_t kMostPropertyFileOctets = 64 * 1024;

/// One `name = value` a line; blanks around both are dropped, empty lines and those that begin with
/// # are passed over, and so is a byte order mark at the beginning. None propagates. Errors, with
/// the line: property_unknown for a name that is not in property::kOfParticipants, with the nearest
/// one that is; invalid_property (no name, no =, a name twice, a control character).
Result<PropertyList> parse_properties(std::string_view text);

/// The properties of a file. Errors: those, and file_not_found, file_unreadable, file_too_large.
Result<PropertyList> read_property_file(const std::filesystem::path& path);

}  // namespace ddssec::spi
