// Refuses hostile or foreign XML before a parser sees it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "base/result.hpp"

namespace ddssec::governance {

/// The largest document that is read, in octets.
inline constexpr std::size_t kMaxXmlOctets = 16 * 1024 * 1024;
/// The largest number of elements in one document.
inline constexpr std::size_t kMaxXmlElements = 1'000'000;
/// The deepest nesting of elements; a permissions document needs 8.
inline constexpr int kMaxXmlDepth = 32;

/// The largest number of attributes of one element; tinyxml2 compares each with all before it.
inline constexpr int kMaxXmlAttributes = 64;

/// Checks the octets of a document for everything that tinyxml2 9 accepts or handles badly: size,
/// depth, number of elements and attributes, UTF-8, control characters, DOCTYPE and other
/// declarations, processing instructions, entities, text outside the root element. One processing
/// instruction is allowed, right after the XML declaration: <?ddssec revision="7"?>. It is a check,
/// not a parser: whether start and end tags match is left to the parser. Errors (with line):
/// value_not_revision, xml_too_large, xml_control_character, xml_doctype, xml_entity, xml_encoding,
/// xml_processing_instruction, xml_too_deep, xml_too_many_attributes, xml_not_well_formed.
Status check_xml(std::string_view document);

/// Returns the revision in `ddssec revision="7"`, the inside of that processing instruction: from 1
/// to 2^32 - 1, without leading zeros. Empty if it has another form.
std::optional<std::uint32_t> revision_in(std::string_view instruction);

}  // namespace ddssec::governance
