// The only place that parses XML: a document that passed check_xml and tinyxml2, with checked
// access to its elements.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "governance/model.hpp"

namespace tinyxml2 {
class XMLElement;
}  // namespace tinyxml2

namespace ddssec::governance {

/// Returns "<name>", as errors show elements.
std::string in_brackets(std::string_view name);

/// One element; borrowed from its XmlDocument. A default-constructed one stands for "absent".
class XmlElement {
 public:
  XmlElement() = default;
  explicit XmlElement(const tinyxml2::XMLElement* element) : element_(element) {}

  explicit operator bool() const { return element_ != nullptr; }
  std::string_view name() const;
  /// Returns the line in the file, from 1.
  int line() const;
  /// Returns the value of an attribute, or nullptr.
  const char* attribute(const char* name) const;
  std::vector<std::string_view> attribute_names() const;
  /// Returns a path such as "/dds/permissions/grant[2]", counted among siblings of the same name if
  /// there are several.
  std::string path() const;
  /// Returns the parent element; absent for the root.
  XmlElement parent() const;
  XmlElement first_child() const;
  XmlElement next_sibling() const;

  /// Returns the text of an element without children, with entities resolved and surrounding white
  /// space removed. Text in several pieces is refused, because products read it differently.
  /// Errors: element_unknown, value_in_pieces.
  Result<std::string> text() const;
  /// Returns the same as text(), with the white space around it.
  Result<std::string> raw_text() const;
  /// True if there is white space before or after the text.
  bool is_padded() const;
  /// Returns the same as text(), but not an empty text. Errors: as text(), element_empty.
  Result<std::string> nonempty_text() const;

  /// Success if the element has only the attributes must_interpret, `allowed` and those of XML
  /// namespaces. An element marked must_interpret="false" may have any. Errors: attribute_unknown,
  /// value_not_boolean.
  Status check_attributes(std::string_view allowed = {}) const;
  /// True if the element is marked must_interpret="false" (DDS-Security 1.2, extensibility).
  bool may_be_ignored() const;
  /// Success if there is no text between the children. Error: text_unexpected.
  Status check_no_text() const;

 private:
  const tinyxml2::XMLElement* element_ = nullptr;
};

/// A parsed document. Move-only.
class XmlDocument {
 public:
  /// Parses a document. `first_line` is the line of the file on which the octets begin, so that all
  /// line numbers refer to the file. Errors: those of check_xml, and xml_not_well_formed from the
  /// parser.
  static Result<XmlDocument> parse(BytesView octets, int first_line = 1);

  XmlElement root() const;
  /// Returns the revision of the processing instruction <?ddssec revision="7"?>, or 0 if there is
  /// none.
  std::uint32_t revision() const;

  ~XmlDocument();
  XmlDocument(XmlDocument&&) noexcept;
  XmlDocument& operator=(XmlDocument&&) noexcept;

 private:
  struct ParsedDocument;
  friend class XmlElement;
  explicit XmlDocument(std::unique_ptr<ParsedDocument> document);
  std::unique_ptr<ParsedDocument> document_;
};

/// One kind of child that an element may have.
struct ChildSpec {
  std::string_view name;
  enum class Count : std::uint8_t { optional, once, many } count = Count::once;
};

/// The children of an element, assigned to rows of a table. Their order is free.
class XmlChildren {
 public:
  /// Assigns the children of `parent`. Errors: element_unknown, element_repeated, element_missing
  /// (for Count::once), text_unexpected, and those of check_attributes for each child in the table.
  static Result<XmlChildren> of(XmlElement parent, std::span<const ChildSpec> specs);

  /// Returns the child of row `spec`; absent if it is optional and missing.
  XmlElement one(std::size_t spec) const;
  /// Returns all children of known kinds in document order, with their rows.
  const std::vector<std::pair<std::size_t, XmlElement>>& all() const { return all_; }
  /// True if the children are in the order of the table.
  bool in_order() const;

 private:
  std::vector<std::pair<std::size_t, XmlElement>> all_;
};

/// The largest number of notes for one document.
inline constexpr std::size_t kMaxNotes = 100;

/// Adds a note. Above kMaxNotes it only counts the place, in the last note of the same text.
void add_note(std::vector<Note>& notes, NoteKind kind, XmlElement at, std::string_view text);

}  // namespace ddssec::governance
