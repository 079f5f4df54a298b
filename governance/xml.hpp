// The front door for XML: a document that passed check_xml and tinyxml2, and careful access to it.
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

/// "<name>", as errors show elements.
std::string in_brackets(std::string_view name);

/// One element; borrowed from its XmlDocument. A default-made one stands for "absent".
class XmlElement {
 public:
  XmlElement() = default;
  explicit XmlElement(const tinyxml2::XMLElement* element) : element_(element) {}

  explicit operator bool() const { return element_ != nullptr; }
  std::string_view name() const;
  /// Of the file, from 1.
  int line() const;
  /// The value of an attribute, or nullptr.
  const char* attribute(const char* name) const;
  std::vector<std::string_view> attribute_names() const;
  /// "/dds/permissions/grant[2]", counted among siblings of the same name if there are several.
  std::string path() const;
  /// The element around this one; absent for the root.
  XmlElement parent() const;
  XmlElement first_child() const;
  XmlElement next_sibling() const;

  /// The text of an element without children: entities resolved, surrounding white space removed.
  /// A text in several pieces is refused, since products read it differently. Errors:
  /// element_unknown, value_in_pieces.
  Result<std::string> text() const;
  /// The same as text(), with the white space around it.
  Result<std::string> raw_text() const;
  /// True if there is white space before or behind the text.
  bool is_padded() const;
  /// The same as text(), but empty text is element_empty.
  Result<std::string> nonempty_text() const;

  /// Refuses attributes other than must_interpret, `allowed` and those of XML namespaces; an
  /// element marked must_interpret="false" may have any. Errors: attribute_unknown,
  /// value_not_boolean.
  Status check_attributes(std::string_view allowed = {}) const;
  /// True if marked must_interpret="false" (DDS-Security 1.2, extensibility).
  bool may_be_ignored() const;
  /// Refuses text between the children. Error: text_unexpected.
  Status check_no_text() const;

 private:
  const tinyxml2::XMLElement* element_ = nullptr;
};

/// A parsed document. Move-only.
class XmlDocument {
 public:
  /// `first_line`: of the file that the octets are a part of; all lines are told as the file's.
  /// Errors: those of check_xml, and xml_not_well_formed from the parser.
  static Result<XmlDocument> parse(BytesView octets, int first_line = 1);

  XmlElement root() const;

  ~XmlDocument();
  XmlDocument(XmlDocument&&) noexcept;
  XmlDocument& operator=(XmlDocument&&) noexcept;

 private:
  struct Parsed;
  friend class XmlElement;
  explicit XmlDocument(std::unique_ptr<Parsed> document);
  std::unique_ptr<Parsed> document_;
};

/// One kind of child that an element may have.
struct ChildSpec {
  std::string_view name;
  enum class Count : std::uint8_t { optional, once, many } count = Count::once;
};

/// The children of an element, sorted out by a table. Order is free.
class XmlChildren {
 public:
  /// Errors: element_unknown, element_repeated, element_missing (of Count::once), text_unexpected,
  /// and those of check_attributes for each child that is listed in the table.
  static Result<XmlChildren> of(XmlElement parent, std::span<const ChildSpec> specs);

  /// The child of row `spec`; absent if it is optional and not there.
  XmlElement one(std::size_t spec) const;
  /// All children of known kinds in document order, with their rows.
  const std::vector<std::pair<std::size_t, XmlElement>>& all() const { return all_; }
  /// True if they stand in the order of the table.
  bool in_order() const;

 private:
  std::vector<std::pair<std::size_t, XmlElement>> all_;
};

/// The most notes that are kept for one document.
inline constexpr std::size_t kMostNotes = 100;

/// Adds a note unless there are kMostNotes.
void add_note(std::vector<Note>& notes, NoteKind kind, XmlElement at, std::string_view text);

}  // namespace ddssec::governance
