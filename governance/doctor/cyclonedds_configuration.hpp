// Cyclone DDS's configuration, as far as the doctor reads it: as leniently as Cyclone DDS does.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/bytes.hpp"
#include "base/result.hpp"

namespace ddssec::governance::doctor {

/// The texts of all that CYCLONEDDS_URI (or `uri`) names: XML, or files with commas between them.
/// Nothing if the variable is not set or a file cannot be read.
std::optional<std::string> cyclonedds_configuration();
std::optional<std::string> cyclonedds_configuration(std::string_view uri);

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

}  // namespace ddssec::governance::doctor
