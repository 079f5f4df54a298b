// Reads those parts of Cyclone DDS's configuration that the doctor needs, as leniently as Cyclone
// DDS does.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::governance::doctor {

/// Reads the contents of everything that CYCLONEDDS_URI (or `uri`) names: XML, or files separated
/// by commas. Empty if the variable is not set or empty, or if a file cannot be read. A folder is
/// read as an empty file, as Cyclone DDS 0.10.2 does (measured).
std::optional<std::string> cyclonedds_configuration();
std::optional<std::string> cyclonedds_configuration(std::string_view uri);

/// Returns the number of octets at the end of that text that are in the variable itself, not in a
/// file.
std::size_t inline_octets(std::string_view uri);

/// Returns the files that `uri` names, whether they exist or not.
std::vector<std::filesystem::path> files_named_by(std::string_view uri);

/// Returns the first folder among the files that `uri` names; empty if there is none.
std::filesystem::path folder_named_by(std::string_view uri);

/// Reads the content of the file. An empty file gives no octets, because Cyclone DDS starts with
/// it, without security. Errors: those of load_uri, except item_empty.
Result<Bytes> load_or_empty(std::string_view uri, std::string_view name, std::size_t max_octets);

/// Returns the text without XML comments.
std::string without_comments(std::string_view text);

/// A start tag and the text after it; views into the text.
struct StartTag {
  std::string_view attributes;  ///< the text up to the '>'
  std::string_view after;
};
/// Finds the first start tag `name` (given in lower case), in any letter case; empty if there is
/// none.
std::optional<StartTag> find_tag(std::string_view text, std::string_view name);

/// Returns the values of the first element `name` in each element `section` of a text in lower
/// case, without surrounding blanks.
std::vector<std::string_view> values_within(std::string_view text, std::string_view section,
                                            std::string_view name);

}  // namespace ddssec::governance::doctor
