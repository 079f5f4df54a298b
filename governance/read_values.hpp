// Parses values that both kinds of documents contain. For governance/ only.
#pragma once

#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "governance/model.hpp"
#include "governance/xml.hpp"

namespace ddssec::governance {

/// The state of a reader: notes, and a count that is limited by kMaxEntries.
class ReadContext {
 public:
  explicit ReadContext(std::vector<Note>& notes) : notes_(notes) {}
  void note(NoteKind kind, XmlElement at, std::string_view text) {
    add_note(notes_, kind, at, text);
  }
  void note(Note note) { notes_.push_back(std::move(note)); }
  /// Counts one rule, grant or expression. Error: too_many_rules.
  Status count(XmlElement at);

 private:
  std::vector<Note>& notes_;
  std::size_t entries_ = 0;
};

/// Notes blanks around the element's text.
void note_padding(ReadContext& context, XmlElement element);
/// As note_padding, for a value with which Fast DDS then refuses the document.
void note_refused_padding(ReadContext& context, XmlElement element);
/// Notes elements and attributes, here and below, that DDS-Security 1.1 does not have. check_xml
/// has bounded the nesting.
void note_extensions(ReadContext& context, XmlElement element);
/// Notes the first end tag with white space in it, which XML 1.0 allows.
void note_end_tags(ReadContext& context, BytesView xml, int first_line);
/// Notes a byte order mark before the text.
void note_byte_order_mark(ReadContext& context, BytesView text, XmlElement root);
/// Returns the only child of <dds>, which must be named `name`. Error: document_kind.
Result<XmlElement> document_body(const XmlDocument& document, std::string_view name);
Result<bool> read_boolean(ReadContext& context, XmlElement element);
/// The protection kinds that an element may have: all, or those without origin authentication.
enum class AllowedKinds : std::uint8_t { all, basic };
/// Reads a protection kind, and refuses one that the element may not have.
Result<ProtectionKind> read_protection_kind(ReadContext& context, XmlElement element,
                                            AllowedKinds allowed);
/// Reads a set of domains. A range without <max> ends with the highest id, one without <min> begins
/// with 0 (DDS-Security 1.2, clause 10.4.1.2.3, and its rule for all domains in 10.4.1.2.7).
Result<DomainSet> read_domains(ReadContext& context, XmlElement element);
/// Reads the texts of all children of `list`. There must be at least one, and all must be named
/// `name`. If `may_be_empty`, their text may be empty.
Result<std::vector<Text>> read_texts(ReadContext& context, XmlElement list, std::string_view name,
                                     bool may_be_empty = false);

}  // namespace ddssec::governance
