// A file of properties (security.properties), for settings that a host cannot pass otherwise.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string_view>

#include "base/result.hpp"
#include "plugins/spi/token.hpp"

namespace ddssec::spi {

inline constexpr std::size_t kMaxPropertyFileOctets = 64 * 1024;

/// Parses one `name = value` per line. Blanks around both are removed. Empty lines, lines that
/// begin with #, and a byte order mark at the beginning are skipped. No property propagates.
/// Errors, with the line: property_unknown for a name that is not in property::kOfParticipants,
/// with the nearest valid name; invalid_property (no name, no =, a repeated name, a control
/// character).
Result<PropertyList> parse_properties(std::string_view text);

/// Reads the properties of a file of at most kMaxPropertyFileOctets; none if it is empty. Errors:
/// those of parse_properties, file_not_found, file_unreadable, file_too_large.
Result<PropertyList> read_property_file(const std::filesystem::path& path);

}  // namespace ddssec::spi
