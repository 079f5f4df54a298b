// Lists the elements of Cyclone DDS's configuration that do not concern security. For
// governance/doctor/ only.
#pragma once

#include <string>
#include <string_view>

namespace ddssec::governance::doctor {

/// Returns the path of a section of <Domain> whose elements are known here, such as "general";
/// empty for any other name. Names are in lower case. Paths are those of Cyclone DDS 0.10.2 and
/// 0.10.5.
std::string section_path(std::string_view name);
/// Returns the path of an element within: "discovery/ports" of "discovery" and "ports".
std::string path_inside(std::string_view path, std::string_view element);

/// True if Cyclone DDS knows the element directly inside the one with this path. The second
/// function tells the same for its attribute.
bool is_known_inside(std::string_view path, std::string_view element);
bool is_known_attribute(std::string_view path, std::string_view attribute);

/// True if the element must not contain text.
bool has_elements_only(std::string_view path);
/// True if a list may contain several of the element, such as <Peer>.
bool is_repeated(std::string_view path);

}  // namespace ddssec::governance::doctor
