#include "governance/read_values.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include "base/text.hpp"
#include "governance/read.hpp"

namespace ddssec::governance {
namespace {

constexpr std::string_view kBlanks = " \t\r\n";

using Count = ChildSpec::Count;

// The elements of both kinds of documents, in alphabetical order.
constexpr std::string_view kElements[] = {
    "algorithm",
    "allow_rule",
    "allow_unauthenticated_participants",
    "allowed_crypto_algorithms",
    "data_protection_kind",
    "data_tags",
    "default",
    "deny_rule",
    "digital_signature",
    "digital_signature_identity_trust_chain",
    "digital_signature_trust_chain",
    "discovery_protection_kind",
    "domain_access_rules",
    "domain_rule",
    "domains",
    "enable_discovery_protection",
    "enable_join_access_control",
    "enable_key_revision",
    "enable_liveliness_protection",
    "enable_read_access_control",
    "enable_write_access_control",
    "grant",
    "id",
    "id_range",
    "key_establishment",
    "liveliness_protection_kind",
    "max",
    "metadata_protection_kind",
    "min",
    "name",
    "not_after",
    "not_before",
    "partition",
    "partitions",
    "permissions",
    "publish",
    "relay",
    "rtps_protection_kind",
    "rtps_psk_protection_kind",
    "subject_name",
    "subject_name_expression",
    "subscribe",
    "symmetric_cipher",
    "tag",
    "tag_expression",
    "topic",
    "topic_access_rules",
    "topic_expression",
    "topic_rule",
    "topics",
    "validity",
    "value",
};
static_assert(std::ranges::is_sorted(kElements));

// Measured with Cyclone DDS 0.10.2 and Fast DDS 2.9.1: 010 is domain 8 for one and 10 for the
// other.
constexpr const char* kLeadingZero =
    "Cyclone DDS reads a number with a leading zero as octal, other products as decimal";

Result<DomainId> read_domain_id(XmlElement element) {
  DDSSEC_ASSIGN_OR_RETURN(const std::string text, element.nonempty_text());
  DomainId id = -1;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), id);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  const bool has_leading_zero = text.size() > 1 && text.starts_with('0');
  if (!whole || has_leading_zero || text.starts_with('-') || id > kMaxGovernedDomainId) {
    return fail(Code::value_not_domain_id,
                {.line = element.line(),
                 .field = in_brackets(element.name()),
                 .expected = has_leading_zero ? "0 to 230, without leading zeros" : "0 to 230",
                 .found = text,
                 .note = has_leading_zero ? kLeadingZero : ""});
  }
  return id;
}

Result<DomainRange> read_range(ReadContext& context, XmlElement element) {
  constexpr ChildSpec kSpecs[] = {{"min", Count::optional}, {"max", Count::optional}};
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(element, kSpecs));
  const XmlElement min = children.one(0);
  const XmlElement max = children.one(1);
  if (!min && !max) {
    return fail(Code::element_missing,
                {.line = element.line(), .field = "<id_range>", .expected = "<min> and <max>"});
  }
  DomainRange range{.first = 0, .last = kMaxGovernedDomainId, .is_open = !max};
  if (min) {
    DDSSEC_ASSIGN_OR_RETURN(range.first, read_domain_id(min));
  }
  if (max) {
    DDSSEC_ASSIGN_OR_RETURN(range.last, read_domain_id(max));
  }
  if (!max)
    context.note(NoteKind::no_max, element,
                 "has no <max>: it has no end, but Cyclone DDS and Fast DDS read domain " +
                     std::to_string(range.first) + " alone; write both");
  if (!min)
    context.note(NoteKind::no_min, element,
                 "has no <min>: it begins with domain 0, but Cyclone DDS refuses it; write both");
  if (range.first > range.last) {
    return fail(Code::domain_range_reversed,
                {.line = element.line(),
                 .field = "<id_range>",
                 .expected = "min not above max",
                 .found = std::to_string(range.first) + " to " + std::to_string(range.last)});
  }
  return range;
}

}  // namespace

void note_padding(ReadContext& context, XmlElement element) {
  if (element.is_padded())
    context.note(NoteKind::padding, element,
                 "has blanks around its value: Fast DDS keeps them and matches no name, "
                 "so that what a rule denies is not denied");
}

void note_refused_padding(ReadContext& context, XmlElement element) {
  if (element.is_padded())
    context.note(NoteKind::refused_padding, element,
                 "has blanks around its value: Fast DDS refuses the document");
}

namespace {

bool is_of_permissions(XmlElement element) {
  const auto rule = element.parent();
  return rule && (rule.name() == "allow_rule" || rule.name() == "deny_rule");
}

void note_tag(ReadContext& context, XmlElement tag, bool is_of_rule) {
  if (!is_of_rule) return context.note(NoteKind::newer_element, tag, "came with DDS-Security 1.2");
  context.note(NoteKind::tag_of_rule, tag,
               "came with DDS-Security 1.2: Cyclone DDS ignores it, and takes the rule for "
               "participants without the tag, too");
}

// The first "</name >" outside of comments and CDATA.
std::optional<std::size_t> end_tag_with_blank(std::string_view text) {
  constexpr std::pair<std::string_view, std::string_view> kPassedOver[] = {{"<!--", "-->"},
                                                                           {"<![CDATA[", "]]>"}};
  for (auto at = text.find('<'); at < text.size(); at = text.find('<', at + 1)) {
    const auto rest = text.substr(at);
    const auto* const other = std::ranges::find_if(
        kPassedOver, [&](const auto& one) { return rest.starts_with(one.first); });
    const auto end = rest.find(other == std::end(kPassedOver) ? ">" : other->second);
    if (end == rest.npos) break;
    if (rest.starts_with("</") && kBlanks.contains(rest[end - 1])) return at;
    at += end;
  }
  return std::nullopt;
}

}  // namespace

void note_end_tags(ReadContext& context, BytesView xml, int first_line) {
  const auto text = as_text(xml);
  const auto at = end_tag_with_blank(text);
  if (!at) return;
  const auto name = trimmed(text.substr(*at + 1, text.find('>', *at) - *at - 1), kBlanks);
  context.note({NoteKind::end_tag_blank,
                first_line + static_cast<int>(std::ranges::count(text.substr(0, *at), '\n')),
                {},
                in_brackets(name) +
                    " has a blank or a line break before its '>': Cyclone DDS refuses the "
                    "document"});
}

void note_extensions(ReadContext& context, XmlElement element) {
  constexpr std::string_view kNewer[] = {"enable_key_revision", "rtps_psk_protection_kind",
                                         "allowed_crypto_algorithms", "subject_name_expression",
                                         "tag_expression"};
  if (std::ranges::find(kNewer, element.name()) != std::end(kNewer))
    context.note(NoteKind::newer_element, element, "came with DDS-Security 1.2");
  const bool is_grant = element.name() == "grant";
  for (const auto name : element.attribute_names()) {
    const bool is_usual = name == "xmlns:xsi" || name == "xsi:noNamespaceSchemaLocation" ||
                          (is_grant && name == "name");
    if (!is_usual)
      context.note(
          name == "xmlns" ? NoteKind::default_namespace : NoteKind::other_attribute, element,
          "has the attribute " + std::string(name) + ", which DDS-Security 1.1 does not have");
  }
  const bool holds_domains = element.name() == "domains";
  for (auto child = element.first_child(); child; child = child.next_sibling()) {
    if (holds_domains && child.name() == "tag")
      note_tag(context, child, is_of_permissions(element));
    if (child.may_be_ignored() && !std::ranges::binary_search(kElements, child.name()))
      context.note(NoteKind::passed_over, child,
                   "is passed over, as must_interpret=\"false\" says; Cyclone DDS and Fast DDS "
                   "refuse the document");
    note_extensions(context, child);
  }
}

void note_byte_order_mark(ReadContext& context, BytesView text, XmlElement root) {
  if (as_text(text).starts_with("\xEF\xBB\xBF"))
    context.note(NoteKind::byte_order_mark, root,
                 "comes after a byte order mark, with which Cyclone DDS refuses the document");
}

Status ReadContext::count(XmlElement at) {
  if (++entries_ <= kMaxEntries) return {};
  return fail(Code::too_many_rules,
              {.line = at.line(), .expected = std::to_string(kMaxEntries), .found = "more"});
}

Result<XmlElement> document_body(const XmlDocument& document, std::string_view name) {
  const XmlElement root = document.root();
  const auto document_kind_error = [&](XmlElement at, std::string_view expected) {
    return fail(
        Code::document_kind,
        {.line = at.line(), .expected = in_brackets(expected), .found = in_brackets(at.name())});
  };
  if (root.name() != "dds") return document_kind_error(root, "dds");
  DDSSEC_RETURN_IF_ERROR(root.check_attributes());
  for (XmlElement child = root.first_child(); child; child = child.next_sibling()) {
    if (child.name() != name && !child.may_be_ignored()) return document_kind_error(child, name);
  }
  const ChildSpec specs[] = {{name}};
  DDSSEC_ASSIGN_OR_RETURN(const auto xml_children, XmlChildren::of(root, specs));
  return xml_children.one(0);
}

Result<bool> read_boolean(ReadContext& context, XmlElement element) {
  DDSSEC_ASSIGN_OR_RETURN(const std::string text, element.nonempty_text());
  const std::string lower = ascii_lower(text);
  const bool value = lower == "true" || lower == "1";
  if (!value && lower != "false" && lower != "0") {
    return fail(Code::value_not_boolean, {.line = element.line(),
                                          .field = in_brackets(element.name()),
                                          .expected = "true or false",
                                          .found = text});
  }
  note_refused_padding(context, element);
  constexpr std::string_view kKnownToFastDds[] = {"1", "0", "TRUE", "FALSE", "True", "False"};
  if (text == "true" || text == "false") return value;
  if (std::ranges::find(kKnownToFastDds, text) == std::end(kKnownToFastDds)) {
    context.note(NoteKind::refused_spelling, element,
                 std::string("is ").append(text).append(": Fast DDS refuses the document"));
  } else {
    context.note(NoteKind::boolean_spelling, element,
                 std::string("is ").append(text).append(": every product reads true and false"));
  }
  return value;
}

Result<ProtectionKind> read_protection_kind(ReadContext& context, XmlElement element,
                                            AllowedKinds allowed) {
  DDSSEC_ASSIGN_OR_RETURN(const std::string text, element.nonempty_text());
  note_refused_padding(context, element);
  const std::string upper = ascii_upper(text);
  const auto kind = protection_kind_from(upper);
  if (!kind || (allowed == AllowedKinds::basic && is_origin_authenticated(*kind))) {
    return fail(Code::value_not_protection_kind,
                {.line = element.line(),
                 .field = in_brackets(element.name()),
                 .expected = allowed == AllowedKinds::basic
                                 ? "NONE, SIGN or ENCRYPT"
                                 : "NONE, SIGN, ENCRYPT, SIGN_WITH_ORIGIN_AUTHENTICATION or "
                                   "ENCRYPT_WITH_ORIGIN_AUTHENTICATION",
                 .found = text});
  }
  if (upper != text)
    context.note(NoteKind::kind_spelling, element, "is not in capitals: most products refuse it");
  return *kind;
}

Result<DomainSet> read_domains(ReadContext& context, XmlElement element) {
  constexpr ChildSpec kSpecs[] = {{"id", Count::many},
                                  {"id_range", Count::many},
                                  {"tag", Count::many},
                                  {"tag_expression", Count::many}};
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(element, kSpecs));
  DomainSet domains{.line = element.line()};
  for (const auto& [kind, child] : children.all()) {
    DDSSEC_RETURN_IF_ERROR(context.count(child));
    if (kind == 0) {
      DDSSEC_ASSIGN_OR_RETURN(const DomainId id, read_domain_id(child));
      domains.ranges.push_back({id, id});
    } else if (kind == 1) {
      DDSSEC_ASSIGN_OR_RETURN(const auto range, read_range(context, child));
      domains.ranges.push_back(range);
    } else {
      auto& list = kind == 2 ? domains.tags : domains.tag_expressions;
      // The empty tag is a tag: it is the one that a participant has by default.
      DDSSEC_ASSIGN_OR_RETURN(auto text, child.text());
      list.push_back({std::move(text), child.line()});
    }
  }
  if (domains.ranges.empty()) {
    return fail(Code::element_missing, {.line = element.line(),
                                        .field = in_brackets(element.name()),
                                        .expected = "<id> or <id_range>"});
  }
  return domains;
}

Result<std::vector<Text>> read_texts(ReadContext& context, XmlElement list, std::string_view name,
                                     bool may_be_empty) {
  const ChildSpec specs[] = {{name, Count::many}};
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(list, specs));
  std::vector<Text> texts;
  texts.reserve(children.all().size());
  for (const auto& [kind, child] : children.all()) {
    DDSSEC_RETURN_IF_ERROR(context.count(child));
    note_padding(context, child);
    DDSSEC_ASSIGN_OR_RETURN(auto text, may_be_empty ? child.text() : child.nonempty_text());
    texts.push_back({std::move(text), child.line(), child.is_padded()});
  }
  if (texts.empty()) {
    return fail(
        Code::element_missing,
        {.line = list.line(), .field = in_brackets(list.name()), .expected = in_brackets(name)});
  }
  return texts;
}

}  // namespace ddssec::governance
