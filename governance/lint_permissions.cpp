#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "governance/cyclonedds_subject.hpp"
#include "governance/date_time.hpp"
#include "governance/grant.hpp"
#include "governance/lint.hpp"
#include "governance/lint_grant.hpp"
#include "governance/ros_node.hpp"
#include "governance/subject_spelling.hpp"
#include "pki/certificate_source.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::governance {
namespace {

using enum Rule;

void add_notes(LintFindings& out, const Permissions& document) {
  const std::vector<std::string> stock = {kCyclone, kFastDds};
  for (const auto& note : document.notes) {
    switch (note.kind) {
      case NoteKind::no_zone:
        out.add(PERM003, note, {kFastDds});
        break;
      case NoteKind::fraction:
        out.add({.rule = PERM002,
                 .message = note.text,
                 .line = note.line,
                 .path = note.path,
                 .hint = "write whole seconds",
                 .severity = Severity::informational});
        break;
      case NoteKind::no_min:
      case NoteKind::no_max:
        out.add(PERM004, note, stock);
        break;
      case NoteKind::padding:
      case NoteKind::refused_padding:
        out.add(PERM005, note, {kFastDds});
        break;
      case NoteKind::byte_order_mark:
      case NoteKind::passed_over:
      case NoteKind::newer_element:
      case NoteKind::tag_of_rule:
      case NoteKind::default_namespace:
      case NoteKind::other_attribute:
        out.add(PERM006, note, stock);
        break;
      case NoteKind::end_tag_blank:
        out.add(PERM001, note, {kCyclone});
        break;
      case NoteKind::order:
      case NoteKind::accepted_order:
      case NoteKind::no_name:
      case NoteKind::no_default:
      case NoteKind::refused_spelling:
        out.add(PERM001, note, {kFastDds});
        break;
      case NoteKind::boolean_spelling:
      case NoteKind::kind_spelling:
      case NoteKind::no_algorithms:
        break;  // notes of governance documents
    }
  }
}

void diagnose_dates(LintFindings& out, const GrantPlace& place, const PermissionsUse& use) {
  const auto from = place.grant().validity.not_before, to = place.grant().validity.not_after;
  const auto add = [&](Severity severity, std::string message) {
    auto finding = place.about(PERM002, std::move(message));
    finding.severity = severity;
    out.add(std::move(finding));
  };
  if (to - from <= std::chrono::seconds(1))
    add(from == to ? Severity::error : Severity::warning,
        from == to
            ? fmt::format("the grant is never valid: it begins and ends at {}", to_string(from))
            : fmt::format("the grant is valid for one second only, at {}", to_string(from)));
  if (use.now && *use.now >= to)
    add(Severity::error, fmt::format("the grant ended at {}", to_string(to)));
  if (use.now && *use.now < from)
    add(Severity::warning, fmt::format("the grant begins at {} only", to_string(from)));
  if (use.certificate && to > use.certificate->not_after())
    add(Severity::warning, fmt::format("the grant ends at {}, after the certificate ({})",
                                       to_string(to), to_string(use.certificate->not_after())));
  if (place.grant().validity.is_read_alike_by_cyclonedds) return;
  auto finding = place.about(PERM002, fmt::format("Cyclone DDS {}", kEndReadAsPast));
  finding.hint = std::string(kEndReadAsPastHint);
  finding.products = {kCyclone};
  out.add(std::move(finding));
}

// A key that is the same for every spelling of a subject.
std::string key_of(const Grant& grant) {
  const auto name = pki::SubjectName::parse(grant.subject_name);
  if (!name || grant.subject_is_expression) return "text " + grant.subject_name;
  return "name " + name->key();
}

bool overlap_in_time(const Grant& one, const Grant& other) {
  return one.validity.not_before < other.validity.not_after &&
         other.validity.not_before < one.validity.not_after;
}

// Successive grants for one subject are a renewal, but Cyclone DDS knows only the first.
void diagnose_repeated_subjects(LintFindings& out, const std::vector<GrantPlace>& places) {
  std::map<std::string, const GrantPlace*> first;
  for (const auto& place : places) {
    const auto [entry, is_new] = first.try_emplace(key_of(place.grant()), &place);
    if (is_new) continue;
    const auto& earlier = entry->second->grant();
    auto finding = place.about(
        PERM010, fmt::format("the grant for {} is dead: there is one in line {} already",
                             in_quotes(place.grant().subject_name), earlier.line));
    if (!overlap_in_time(earlier, place.grant())) {
      finding.severity = Severity::warning;
      finding.products = {kCyclone};
    }
    out.add(std::move(finding));
  }
}

// Reports an expression for many subjects before the grant of one of them. Each comparison takes
// microseconds, and a document may hold thousands of grants, so only the first expressions are
// compared.
void diagnose_matched_subjects(LintFindings& out, const std::vector<GrantPlace>& places) {
  constexpr std::size_t kMaxExpressions = 64;
  std::vector<const Grant*> expressions;
  for (const auto& place : places) {
    const auto& own = place.grant();
    if (own.subject_is_expression) {
      if (expressions.size() < kMaxExpressions) expressions.push_back(&own);
      continue;
    }
    const auto name = pki::SubjectName::parse(own.subject_name);
    if (!name) continue;
    const auto earlier = std::ranges::find_if(expressions, [&](const Grant* one) {
      return overlap_in_time(*one, own) && is_for(*one, *name);
    });
    if (earlier == expressions.end()) continue;
    out.add(place.about(
        PERM010, fmt::format("the grant for {} is dead: {} in line {} matches this subject, too",
                             in_quotes(own.subject_name), in_quotes((*earlier)->subject_name),
                             (*earlier)->line)));
  }
}

// Reports grants that Cyclone DDS applies to certificates of other subjects. The order of the
// grants counts there.
void diagnose_stray_grants(LintFindings& out, const Permissions& document,
                           const std::vector<GrantPlace>& places) {
  const Permissions* const subjects[] = {&document};
  for (const auto& stray : misapplied_grants(document, subjects)) {
    const auto place = std::ranges::find_if(
        places, [&](const GrantPlace& one) { return &one.grant() == stray.grant; });
    auto finding = place->about(PERM010, to_sentence(stray));
    finding.hint = std::string(kStrayGrantHint);
    finding.products = {kCyclone};
    out.add(std::move(finding));
  }
}

void diagnose_spelling(LintFindings& out, const GrantPlace& place) {
  auto found = misspelt(place.grant());
  if (!found) return;
  auto finding = place.about(PERM011, std::move(found->message));
  if (!found->right.empty())
    finding.hint = fmt::format("write <subject_name>{}</subject_name>", found->right);
  else
    finding.severity = Severity::error;
  finding.products = std::move(found->products);
  out.add(std::move(finding));
}

void diagnose_letters(LintFindings& out, const GrantPlace& place) {
  auto found = letters_beyond_ascii(place.grant());
  if (!found) return;
  auto finding = place.about(PERM011, std::move(found->message));
  finding.hint =
      "name participants in ASCII, or give Fast DDS a document of its own: it reads the letters "
      "themselves, and Cyclone DDS their escapes such as \\C3\\A9";
  finding.products = std::move(found->products);
  out.add(std::move(finding));
}

// Reports a document in which no grant is for the certificate in the certificate's own spelling.
void diagnose_subject(LintFindings& out, const std::vector<GrantPlace>& places,
                      const pki::Certificate& certificate) {
  const auto subject = pki::SubjectName::of(certificate);
  const auto own = std::ranges::find_if(
      places, [&](const GrantPlace& place) { return is_for(place.grant(), subject); });
  const auto hint = fmt::format("write <subject_name>{}</subject_name>", certificate.subject());
  if (own == places.end()) {
    out.add({.rule = PERM011,
             .message = fmt::format("no grant is for the certificate's subject {}; the first is "
                                    "for {}",
                                    in_quotes(certificate.subject()),
                                    in_quotes(places.front().grant().subject_name)),
             .line = places.front().grant().line,
             .path = places.front().path(),
             .hint = hint,
             .severity = Severity::error});
    return;
  }
  const auto& grant = own->grant();
  const bool is_same_text = grant.subject_name == certificate.subject();
  if (grant.subject_is_expression || (is_same_text && !grant.subject_has_line_breaks)) return;
  auto finding = own->about(
      PERM011, is_same_text
                   ? between_line_breaks(grant.subject_name)
                   : fmt::format("{} means the certificate's subject {} in other words",
                                 in_quotes(grant.subject_name), in_quotes(certificate.subject())));
  finding.hint = hint;
  finding.products =
      not_recognising(grant, certificate.subject(), pki::subject_in_utf8(certificate));
  out.add(std::move(finding));
}

void diagnose_names(LintFindings& out, const GrantPlace& place) {
  const auto& grant = place.grant();
  const auto check = [&](std::string_view what, const Text& name) {
    out.add_if_misleading(PERM041, what, name, place.path());
  };
  check("the grant's name", {grant.name, grant.line});
  check("the subject name", {grant.subject_name, grant.line});
  for (const auto& rule : grant.rules)
    for (const auto* list : {&rule.publish, &rule.subscribe, &rule.relay})
      for (const auto& criteria : *list) {
        for (const auto& topic : criteria.topics) check("the topic", topic);
        for (const auto& partition : listed_partitions(criteria)) check("the partition", partition);
      }
}

}  // namespace

Finding too_long_for_peers(std::size_t signed_octets) {
  return {
      .rule = PERM042,
      .message = fmt::format("the signed document has {} octets, and ddssec's plugins send, and "
                             "take from a peer, {} at most: a participant with it does not "
                             "start on them, and is not accepted by participants on them",
                             signed_octets, pki::kMaxSentPermissionsOctets)};
}

std::vector<Finding> lint(const Permissions& permissions, const PermissionsUse& use) {
  LintFindings out(PERM012);
  add_notes(out, permissions);
  std::vector<GrantPlace> places;
  places.reserve(permissions.grants.size());
  for (std::size_t i = 0; i < permissions.grants.size(); ++i)
    places.emplace_back(permissions.grants[i], i + 1);
  for (const auto& place : places) {
    diagnose_dates(out, place, use);
    diagnose_names(out, place);
    if (!use.certificate) diagnose_spelling(out, place);
    diagnose_letters(out, place);
    lint_overlaps(out, place, lint_dead_rules(out, place));
    lint_unmatchable(out, place);
    lint_rights(out, place, use.governance);
    lint_ros(out, place);
  }
  diagnose_repeated_subjects(out, places);
  diagnose_matched_subjects(out, places);
  if (use.signed_octets > pki::kMaxSentPermissionsOctets)
    out.add(too_long_for_peers(use.signed_octets));
  diagnose_stray_grants(out, permissions, places);
  if (auto finding = missing_node_defaults(permissions)) out.add(*std::move(finding));
  if (use.certificate && !places.empty()) diagnose_subject(out, places, *use.certificate);
  return out.take();
}

}  // namespace ddssec::governance
