// Cyclone DDS's configuration, as far as the doctor reads it: as leniently as Cyclone DDS does.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::governance::doctor {

/// The texts of all that CYCLONEDDS_URI (or `uri`) names: XML, or files with commas between them.
/// Nothing if the variable is not set or empty, or if a file cannot be read. A folder is read as an
/// empty file, as Cyclone DDS 0.10.2 does (measured).
std::optional<std::string> cyclonedds_configuration();
std::optional<std::string> cyclonedds_configuration(std::string_view uri);

/// The first folder among the files that `uri` names; empty if there is none.
std::filesystem::path folder_named_by(std::string_view uri);

/// Of an empty file nothing: Cyclone DDS starts with it, and without security. Errors: those of
/// ddssec::load.
Result<Bytes> load_or_empty(std::string_view uri, std::string_view name, std::size_t most);

/// The same without comments.
std::string without_comments(std::string_view text);

/// A start tag of some name and what stands after it; views into the text.
struct StartTag {
  std::string_view attributes;  ///< up to the '>'
  std::string_view after;
};
/// The first start tag `name`, which is lower case, in any case; nothing if there is none.
std::optional<StartTag> find_tag(std::string_view text, std::string_view name);

/// What the first element `name` in each element `section` of a text in lower case holds, without
/// blanks around it.
std::vector<std::string_view> values_within(std::string_view text, std::string_view section,
                                            std::string_view name);

}  // namespace ddssec::governance::doctor
