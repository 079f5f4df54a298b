#include <algorithm>

#include "base/text.hpp"
#include "governance/date_time.hpp"
#include "governance/read.hpp"
#include "governance/read_values.hpp"

namespace ddssec::governance {
namespace {

using Count = ChildSpec::Count;
using std::chrono::seconds;

Result<DateTime> read_time(ReadContext& context, XmlElement element, Round round) {
  DDSSEC_ASSIGN_OR_RETURN(const std::string text, element.nonempty_text());
  const auto moment = parse_date_time(text, round);
  if (!moment) {
    return fail(Code::value_not_date_time, {.line = element.line(),
                                            .field = in_brackets(element.name()),
                                            .expected = "YYYY-MM-DDThh:mm:ss and Z or an offset",
                                            .found = text});
  }
  if (!moment->has_zone) {
    context.note(NoteKind::no_zone, element,
                 "names no zone: read as UTC here, as local time by Fast DDS");
  }
  if (moment->east != std::chrono::minutes(0))
    context.note(NoteKind::no_zone, element,
                 "names an offset from UTC: Fast DDS ignores it, and reads the rest as local time");
  if (text.contains("T24:"))
    context.note(NoteKind::refused_spelling, element,
                 "is a midnight written as 24:00:00: Fast DDS refuses the document");
  if (moment->has_fraction) {
    context.note(NoteKind::fraction, element,
                 std::string("has a fraction of a second: ddssec takes the whole second ") +
                     (round == Round::up ? "after it" : "before it"));
  }
  return *moment;
}

Result<Validity> read_validity(ReadContext& context, XmlElement element) {
  constexpr ChildSpec kSpecs[] = {{"not_before"}, {"not_after"}};
  DDSSEC_ASSIGN_OR_RETURN(const auto child, XmlChildren::of(element, kSpecs));
  if (!child.in_order())
    context.note(NoteKind::order, element,
                 "has its <not_after> before its <not_before>: Fast DDS refuses it");
  // A fraction of a second makes the validity shorter, never longer.
  DDSSEC_ASSIGN_OR_RETURN(const auto begin, read_time(context, child.one(0), Round::up));
  DDSSEC_ASSIGN_OR_RETURN(const auto end, read_time(context, child.one(1), Round::down));
  const Validity validity{.not_before = begin.time,
                          .not_after = end.time,
                          .is_read_alike_by_cyclonedds = end.is_read_alike_by_cyclonedds,
                          .offset_of_not_before = begin.east,
                          .offset_of_not_after = end.east};
  if (validity.not_before > validity.not_after) {
    const bool is_within_a_second = validity.not_before - validity.not_after == seconds(1);
    return fail(
        Code::validity_reversed,
        {.line = element.line(),
         .field = "<validity>",
         .expected = "not_before before not_after",
         .found = child.one(0).text().value_or("") + " to " + child.one(1).text().value_or(""),
         .note = is_within_a_second ? "no whole second lies between them" : ""});
  }
  return validity;
}

// A tag holds pairs of name and value; the schema lets one element repeat them.
Status read_tag(ReadContext& context, XmlElement element, std::vector<DataTag>& tags) {
  constexpr ChildSpec kSpecs[] = {{"name", Count::many}, {"value", Count::many}};
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(element, kSpecs));
  const auto& all = children.all();
  for (std::size_t i = 0; i < all.size() || i == 0; i += 2) {
    if (i >= all.size() || all[i].first != 0 || i + 1 >= all.size() || all[i + 1].first != 1) {
      return fail(
          Code::element_missing,
          {.line = element.line(), .field = "<tag>", .expected = "a <name> and then a <value>"});
    }
    DDSSEC_RETURN_IF_ERROR(context.count(all[i].second));
    DDSSEC_ASSIGN_OR_RETURN(auto name, all[i].second.nonempty_text());
    DDSSEC_ASSIGN_OR_RETURN(auto value, all[i + 1].second.text());
    tags.push_back({std::move(name), std::move(value)});
  }
  return {};
}

Result<std::vector<DataTag>> read_data_tags(ReadContext& context, XmlElement element) {
  constexpr ChildSpec kSpecs[] = {{"tag", Count::many}};
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(element, kSpecs));
  std::vector<DataTag> tags;
  for (const auto& [kind, child] : children.all())
    DDSSEC_RETURN_IF_ERROR(read_tag(context, child, tags));
  if (tags.empty()) {
    return fail(Code::element_missing,
                {.line = element.line(), .field = "<data_tags>", .expected = "<tag>"});
  }
  return tags;
}

Result<Criteria> read_criteria(ReadContext& context, XmlElement element) {
  constexpr ChildSpec kSpecs[] = {
      {"topics"}, {"partitions", Count::optional}, {"data_tags", Count::optional}};
  DDSSEC_ASSIGN_OR_RETURN(const auto child, XmlChildren::of(element, kSpecs));
  Criteria criteria{.line = element.line()};
  DDSSEC_ASSIGN_OR_RETURN(criteria.topics, read_texts(context, child.one(0), "topic"));
  if (const auto e = child.one(1)) {
    // An empty <partition> names the default partition.
    DDSSEC_ASSIGN_OR_RETURN(criteria.partitions, read_texts(context, e, "partition", true));
  }
  if (const auto e = child.one(2)) {
    DDSSEC_ASSIGN_OR_RETURN(criteria.data_tags, read_data_tags(context, e));
  }
  return criteria;
}

// Measured: Fast DDS takes <publish> and <subscribe> in any order.
void note_order(ReadContext& context, XmlElement rule, const XmlChildren& children) {
  if (children.all().front().first != 0)
    context.note(NoteKind::order, rule, "does not begin with <domains>: Fast DDS refuses it");
  else if (!children.in_order())
    context.note(NoteKind::accepted_order, rule,
                 "is not in the schema's order: Fast DDS takes it, others may not");
}

Result<GrantRule> read_rule(ReadContext& context, XmlElement element) {
  constexpr ChildSpec kSpecs[] = {
      {"domains"}, {"publish", Count::many}, {"subscribe", Count::many}, {"relay", Count::many}};
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(element, kSpecs));
  note_order(context, element, children);
  GrantRule rule{.allow = element.name() == "allow_rule", .line = element.line()};
  DDSSEC_ASSIGN_OR_RETURN(rule.domains, read_domains(context, children.one(0)));
  for (const auto& [kind, child] : children.all()) {
    if (kind == 0) continue;
    DDSSEC_RETURN_IF_ERROR(context.count(child));
    auto& list = kind == 1 ? rule.publish : kind == 2 ? rule.subscribe : rule.relay;
    DDSSEC_ASSIGN_OR_RETURN(auto criteria, read_criteria(context, child));
    list.push_back(std::move(criteria));
  }
  return rule;
}

Result<bool> read_default(ReadContext& context, XmlElement element) {
  DDSSEC_ASSIGN_OR_RETURN(const std::string text, element.nonempty_text());
  note_refused_padding(context, element);
  if (text == "ALLOW") return true;
  if (text == "DENY") return false;
  return fail(
      Code::value_not_default,
      {.line = element.line(), .field = "<default>", .expected = "ALLOW or DENY", .found = text});
}

enum GrantChild : std::size_t {
  kSubjectName,
  kSubjectExpression,
  kValidity,
  kAllowRule,
  kDenyRule,
  kDefault,
};

constexpr ChildSpec kGrantSpecs[] = {{"subject_name", Count::optional},
                                     {"subject_name_expression", Count::optional},
                                     {"validity"},
                                     {"allow_rule", Count::many},
                                     {"deny_rule", Count::many},
                                     {"default", Count::optional}};

Status read_subject(XmlElement element, const XmlChildren& children, Grant& grant) {
  const XmlElement name = children.one(kSubjectName);
  const XmlElement expression = children.one(kSubjectExpression);
  if (static_cast<bool>(name) == static_cast<bool>(expression)) {
    return fail(name ? Code::element_repeated : Code::element_missing,
                {.line = element.line(),
                 .field = "<grant>",
                 .expected = "one <subject_name> or <subject_name_expression>"});
  }
  grant.subject_is_expression = !name;
  const auto& subject = name ? name : expression;
  DDSSEC_ASSIGN_OR_RETURN(grant.subject_name, subject.nonempty_text());
  DDSSEC_ASSIGN_OR_RETURN(const auto raw_text, subject.raw_text());
  grant.subject_has_line_breaks = trimmed(raw_text, " ") != grant.subject_name;
  return {};
}

// Allow and deny rules may be mixed. The place of <default> is noted where <default> is read.
void note_order_of_grant(ReadContext& context, XmlElement grant, const XmlChildren& children) {
  const auto place = [](std::size_t kind) {
    return kind <= kSubjectExpression ? 0 : kind == kValidity ? 1 : 2;
  };
  const auto& all = children.all();
  if (!std::ranges::is_sorted(all, {}, [&](const auto& child) { return place(child.first); }))
    context.note(NoteKind::order, grant,
                 "does not begin with <subject_name> and <validity>: Fast DDS refuses it");
}

Result<Grant> read_grant(ReadContext& context, XmlElement element) {
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(element, kGrantSpecs));
  note_order_of_grant(context, element, children);
  Grant grant{.line = element.line()};
  const char* const name = element.attribute("name");
  if (name != nullptr)
    grant.name = name;
  else
    context.note(NoteKind::no_name, element, "has no name: Fast DDS refuses it");
  DDSSEC_RETURN_IF_ERROR(read_subject(element, children, grant));
  DDSSEC_ASSIGN_OR_RETURN(grant.validity, read_validity(context, children.one(kValidity)));
  for (const auto& [kind, child] : children.all()) {
    if (kind != kAllowRule && kind != kDenyRule) continue;
    DDSSEC_RETURN_IF_ERROR(context.count(child));
    DDSSEC_ASSIGN_OR_RETURN(auto rule, read_rule(context, child));
    grant.rules.push_back(std::move(rule));
  }
  if (const auto e = children.one(kDefault)) {
    if (children.all().back().first != kDefault)
      context.note(NoteKind::order, element,
                   "has its <default> before other elements: Fast DDS refuses it");
    grant.default_line = e.line();
    DDSSEC_ASSIGN_OR_RETURN(grant.default_allow, read_default(context, e));
  } else {
    context.note(NoteKind::no_default, element,
                 "has no <default>: it denies; some products refuse the document");
  }
  return grant;
}

}  // namespace

Result<Permissions> read_permissions(BytesView xml, int first_line) {
  constexpr ChildSpec kSpecs[] = {{"grant", Count::many}};
  DDSSEC_ASSIGN_OR_RETURN(const auto document, XmlDocument::parse(xml, first_line));
  DDSSEC_ASSIGN_OR_RETURN(const auto body, document_body(document, "permissions"));
  if (document.revision() != 0)
    return fail(Code::xml_processing_instruction, {.line = first_line, .found = "<?"});
  DDSSEC_ASSIGN_OR_RETURN(const auto children, XmlChildren::of(body, kSpecs));
  Permissions permissions;
  ReadContext context(permissions.notes);
  note_byte_order_mark(context, xml, document.root());
  note_end_tags(context, xml, first_line);
  note_extensions(context, document.root());
  for (const auto& [kind, child] : children.all()) {
    DDSSEC_RETURN_IF_ERROR(context.count(child));
    DDSSEC_ASSIGN_OR_RETURN(auto grant, read_grant(context, child));
    permissions.grants.push_back(std::move(grant));
  }
  if (permissions.grants.empty()) {
    return fail(Code::element_missing,
                {.line = body.line(), .field = "<permissions>", .expected = "<grant>"});
  }
  return permissions;
}

}  // namespace ddssec::governance
