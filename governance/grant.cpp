#include "governance/grant.hpp"

#include <algorithm>

#include "governance/pattern.hpp"

namespace ddssec::governance {
namespace {

// True if every attribute of the expression matches one attribute of the subject, and none is left
// over.
bool rdn_matches(const pki::Rdn& expression, pki::Rdn left) {
  for (const auto& wanted : expression) {
    const Pattern pattern(wanted.value, Pattern::Syntax::subject);
    const auto taken = std::ranges::find_if(left, [&](const pki::NameAttribute& a) {
      return a.type == wanted.type && pattern.matches(a.value);
    });
    if (taken == left.end()) return false;
    left.erase(taken);
  }
  return left.empty();
}

// Compares RDN by RDN, forwards or backwards, like names without wildcards.
bool expression_matches(const pki::SubjectName& expression, const pki::SubjectName& subject) {
  const auto wanted = expression.rdns();
  auto rdns = subject.rdns();
  if (std::ranges::equal(wanted, rdns, rdn_matches)) return true;
  std::ranges::reverse(rdns);
  return std::ranges::equal(wanted, rdns, rdn_matches);
}

// False only if the text cannot belong to this subject: without escapes it contains every value
// literally. Parsing a name costs microseconds, and a document may contain thousands.
bool may_be_for(std::string_view text, const pki::SubjectName& subject) {
  if (text.find_first_of("\\\"#") != text.npos) return true;
  return std::ranges::all_of(subject.attributes(), [&](const pki::NameAttribute& a) {
    return text.find(a.value) != text.npos;
  });
}

// The subjects of the first grants, for comparison in an error message.
std::string some_subjects(const Permissions& permissions) {
  constexpr std::size_t kMax = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMax, permissions.grants.size()); ++i) {
    if (i > 0) text += " | ";
    text += permissions.grants[i].subject_name.substr(0, 200);
  }
  const auto more = permissions.grants.size() - std::min(kMax, permissions.grants.size());
  if (more > 0) text += " | and " + std::to_string(more) + " more";
  return text;
}

}  // namespace

bool is_for(const Grant& grant, const pki::SubjectName& subject) {
  if (!grant.subject_is_expression && !may_be_for(grant.subject_name, subject)) return false;
  // A subject that is not a name belongs to no certificate.
  const auto name = pki::SubjectName::parse(grant.subject_name);
  if (!name) return false;
  return grant.subject_is_expression ? expression_matches(*name, subject) : name->matches(subject);
}

const Grant* valid_at(std::span<const Grant* const> grants, WallTime time) {
  const auto found =
      std::ranges::find_if(grants, [&](const Grant* one) { return one->validity.contains(time); });
  return found == grants.end() ? nullptr : *found;
}

Status check_validity(const Grant& grant, WallTime now) {
  if (grant.validity.contains(now)) return {};
  const bool early = now < grant.validity.not_before;
  return fail(
      early ? Code::grant_not_yet_valid : Code::grant_expired,
      {.line = grant.line,
       .field = early ? "<not_before>" : "<not_after>",
       .expected = early ? "a time from " + ddssec::to_string(grant.validity.not_before) + " on"
                         : "a time before " + ddssec::to_string(grant.validity.not_after),
       .found = ddssec::to_string(now),
       .note = "grant of " + grant.subject_name.substr(0, 200)});
}

Result<const Grant*> find_grant(const Permissions& permissions, const pki::SubjectName& subject,
                                std::string_view shown, WallTime now) {
  std::optional<Error> outside;
  for (const auto& grant : permissions.grants) {
    if (!is_for(grant, subject)) continue;
    auto status = check_validity(grant, now);
    if (status) return &grant;
    if (!outside) outside = std::move(status).error();
  }
  if (outside) return std::unexpected(*outside);
  return fail(Code::no_grant_for_subject, {.field = "<subject_name>",
                                           .expected = std::string(shown),
                                           .found = some_subjects(permissions)});
}

}  // namespace ddssec::governance
