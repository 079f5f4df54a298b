// Values that both kinds of documents hold. For governance/ only.
#pragma once

#include <span>
#include <string_view>
#include <vector>

#include "base/result.hpp"
#include "governance/model.hpp"
#include "governance/xml.hpp"

namespace ddssec::governance {

/// How an id_range with only <min> is read.
enum class OpenRange : std::uint8_t {
  just_min,    ///< only that id
  to_highest,  ///< every id from there on
};

/// What a reader carries along: notes, and a count against kMostEntries.
class ReadContext {
 public:
  explicit ReadContext(std::vector<Note>& notes) : notes_(notes) {}
  void note(NoteKind kind, XmlElement at, std::string_view text) {
    add_note(notes_, kind, at, text);
  }
  /// Counts one rule, grant or expression. Error: too_many_rules.
  Status count(XmlElement at);

 private:
  std::vector<Note>& notes_;
  std::size_t entries_ = 0;
};

/// Notes blanks around the element's text.
void note_padding(ReadContext& context, XmlElement element);
/// Notes elements and attributes, here and below, that DDS-Security 1.1 does not have. Nesting was
/// bounded by check_xml.
void note_extensions(ReadContext& context, XmlElement element);
/// The only child of <dds>, which must be named `name`. Error: document_kind.
Result<XmlElement> document_body(const XmlDocument& document, std::string_view name);
Result<bool> read_boolean(ReadContext& context, XmlElement element);
/// `basic`: without origin authentication.
Result<ProtectionKind> read_protection_kind(ReadContext& context, XmlElement element, bool basic);
Result<DomainSet> read_domains(ReadContext& context, XmlElement element, OpenRange open_range);
/// All children of `list`, which must be named `name`: at least one. `may_be_empty`: their text.
Result<std::vector<Text>> read_texts(ReadContext& context, XmlElement list, std::string_view name,
                                     bool may_be_empty = false);

}  // namespace ddssec::governance
