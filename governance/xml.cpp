#include "governance/xml.hpp"

#include <algorithm>

#include <tinyxml2.h>

#include "base/text.hpp"
#include "governance/xml_check.hpp"

namespace ddssec::governance {
namespace {

constexpr std::string_view kSpace = " \t\r\n";
constexpr const char* kMustInterpret = "must_interpret";

std::unexpected<Error> element_error(Code code, XmlElement at, ErrorDetails details) {
  details.line = at.line();
  if (details.field.empty()) details.field = in_brackets(at.name());
  return fail(code, std::move(details));
}

bool means_false(std::string_view text) {
  return text == "false" || text == "FALSE" || text == "False" || text == "0";
}
bool means_true(std::string_view text) {
  return text == "true" || text == "TRUE" || text == "True" || text == "1";
}

bool is_namespace_attribute(std::string_view name) {
  return name == "xmlns" || name.starts_with("xmlns:") || name.starts_with("xsi:") ||
         name.starts_with("xml:");
}

}  // namespace

struct XmlDocument::ParsedDocument final : tinyxml2::XMLDocument {
  int first_line = 1;
};

std::string in_brackets(std::string_view name) { return std::string("<").append(name).append(">"); }

std::string_view XmlElement::name() const { return element_->Name(); }
int XmlElement::line() const {
  const auto* document = static_cast<const XmlDocument::ParsedDocument*>(element_->GetDocument());
  return document->first_line + element_->GetLineNum() - 1;
}
const char* XmlElement::attribute(const char* name) const { return element_->Attribute(name); }
XmlElement XmlElement::parent() const {
  const auto* above = element_->Parent();
  return XmlElement(above ? above->ToElement() : nullptr);
}
XmlElement XmlElement::first_child() const { return XmlElement(element_->FirstChildElement()); }
XmlElement XmlElement::next_sibling() const { return XmlElement(element_->NextSiblingElement()); }

std::vector<std::string_view> XmlElement::attribute_names() const {
  std::vector<std::string_view> names;
  for (const auto* a = element_->FirstAttribute(); a; a = a->Next()) names.emplace_back(a->Name());
  return names;
}

std::string XmlElement::path() const {
  std::string out;
  for (const auto* e = element_; e; e = e->Parent() ? e->Parent()->ToElement() : nullptr) {
    int before = 0;
    for (const auto* s = e; (s = s->PreviousSiblingElement(e->Name()));) ++before;
    const bool is_alone = before == 0 && !e->NextSiblingElement(e->Name());
    std::string step = "/";
    step += e->Name();
    if (!is_alone) step.append("[").append(std::to_string(before + 1)).append("]");
    out.insert(0, step);
  }
  return out;
}

bool XmlElement::is_padded() const {
  const auto* first = element_->FirstChild();
  const auto* last = element_->LastChild();
  if (!first || !first->ToText() || !last->ToText()) return false;
  const std::string_view begin = first->Value(), end = last->Value();
  return (!begin.empty() && kSpace.find(begin.front()) != kSpace.npos) ||
         (!end.empty() && kSpace.find(end.back()) != kSpace.npos);
}

Result<std::string> XmlElement::raw_text() const {
  std::string text;
  for (const auto* node = element_->FirstChild(); node; node = node->NextSibling()) {
    if (node->ToElement()) {
      return element_error(Code::element_unknown, XmlElement(node->ToElement()),
                           {.expected = "text in " + in_brackets(name())});
    }
    // Fast DDS reads the first text only, while other products join the pieces.
    if (!node->ToText() || node->NextSibling()) {
      return element_error(Code::value_in_pieces, *this,
                           {.found = node->ToComment() ? "a comment" : "several pieces of text"});
    }
    text = node->Value();
  }
  return text;
}

Result<std::string> XmlElement::text() const {
  auto whole = raw_text();
  if (whole) *whole = std::string(trimmed(*whole, kSpace));
  return whole;
}

Result<std::string> XmlElement::nonempty_text() const {
  auto content = text();
  if (content && content->empty()) return element_error(Code::element_empty, *this, {});
  return content;
}

bool XmlElement::may_be_ignored() const {
  const char* value = attribute(kMustInterpret);
  return value && means_false(value);
}

Status XmlElement::check_attributes(std::string_view allowed) const {
  for (const auto* a = element_->FirstAttribute(); a; a = a->Next()) {
    const std::string_view attribute_name = a->Name();
    if (attribute_name == kMustInterpret) {
      if (!means_true(a->Value()) && !means_false(a->Value())) {
        return element_error(
            Code::value_not_boolean, *this,
            {.field = in_brackets(name()) + " must_interpret", .found = a->Value()});
      }
    } else if (attribute_name != allowed && !is_namespace_attribute(attribute_name) &&
               !may_be_ignored()) {
      return element_error(Code::attribute_unknown, *this, {.found = std::string(attribute_name)});
    }
  }
  return {};
}

Status XmlElement::check_no_text() const {
  for (const auto* node = element_->FirstChild(); node; node = node->NextSibling()) {
    if (node->ToText() && !trimmed(node->Value(), kSpace).empty()) {
      return element_error(Code::text_unexpected, *this,
                           {.found = std::string(trimmed(node->Value(), kSpace).substr(0, 40))});
    }
  }
  return {};
}

Result<XmlDocument> XmlDocument::parse(BytesView octets, int first_line) {
  if (auto status = check_xml(as_text(octets)); !status) {
    auto details = status.error().details();
    if (details.line > 0) details.line += first_line - 1;
    return fail(status.error().code(), std::move(details));
  }
  auto document = std::make_unique<ParsedDocument>();
  document->first_line = first_line;
  const auto text = as_text(octets);
  if (document->Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS ||
      !document->RootElement()) {
    return fail(Code::xml_not_well_formed, {.line = first_line + document->ErrorLineNum() - 1,
                                            .found = document->ErrorName()});
  }
  return XmlDocument(std::move(document));
}

XmlElement XmlDocument::root() const { return XmlElement(document_->RootElement()); }

// tinyxml2 calls a processing instruction a declaration.
std::uint32_t XmlDocument::revision() const {
  for (const auto* node = document_->FirstChild(); node; node = node->NextSibling())
    if (node->ToDeclaration())
      if (const auto found = revision_in(node->Value())) return *found;
  return 0;
}

XmlDocument::XmlDocument(std::unique_ptr<ParsedDocument> document)
    : document_(std::move(document)) {}
XmlDocument::~XmlDocument() = default;
XmlDocument::XmlDocument(XmlDocument&&) noexcept = default;
XmlDocument& XmlDocument::operator=(XmlDocument&&) noexcept = default;

Result<XmlChildren> XmlChildren::of(XmlElement parent, std::span<const ChildSpec> specs) {
  DDSSEC_RETURN_IF_ERROR(parent.check_no_text());
  XmlChildren children;
  std::uint64_t seen = 0;
  for (XmlElement child = parent.first_child(); child; child = child.next_sibling()) {
    const auto row = std::ranges::find(specs, child.name(), &ChildSpec::name);
    if (row == specs.end()) {
      DDSSEC_RETURN_IF_ERROR(child.check_attributes());
      if (child.may_be_ignored()) continue;
      return element_error(Code::element_unknown, child,
                           {.note = "inside " + in_brackets(parent.name())});
    }
    const auto index = static_cast<std::size_t>(row - specs.begin());
    if (row->count != ChildSpec::Count::many && (seen >> index & 1)) {
      return element_error(Code::element_repeated, child,
                           {.note = "inside " + in_brackets(parent.name())});
    }
    DDSSEC_RETURN_IF_ERROR(child.check_attributes(child.name() == "grant" ? "name" : ""));
    seen |= std::uint64_t{1} << index;
    children.all_.emplace_back(index, child);
  }
  for (std::size_t i = 0; i < specs.size(); ++i) {
    if (specs[i].count == ChildSpec::Count::once && !(seen >> i & 1)) {
      return element_error(Code::element_missing, parent, {.expected = in_brackets(specs[i].name)});
    }
  }
  return children;
}

XmlElement XmlChildren::one(std::size_t spec) const {
  const auto found = std::ranges::find(all_, spec, [](const auto& entry) { return entry.first; });
  return found == all_.end() ? XmlElement() : found->second;
}

bool XmlChildren::in_order() const {
  return std::ranges::is_sorted(all_, {}, [](const auto& entry) { return entry.first; });
}

void add_note(std::vector<Note>& notes, NoteKind kind, XmlElement at, std::string_view text) {
  auto words = in_brackets(at.name()) + " " + std::string(text);
  if (notes.size() < kMaxNotes) {
    notes.push_back(
        {kind, at.line(), at.path(), std::move(words), at.raw_text().value_or(std::string())});
    return;
  }
  const auto last = std::find_if(notes.rbegin(), notes.rend(),
                                 [&](const Note& note) { return note.text == words; });
  if (last != notes.rend()) ++last->more;
}

}  // namespace ddssec::governance
