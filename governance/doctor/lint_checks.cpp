#include "governance/doctor/lint_checks.hpp"

#include <algorithm>

#include "governance/lint.hpp"

namespace ddssec::governance::doctor {
namespace {

// A rule of lint, and the check that reports the same about this participant.
struct SameRule {
  Rule lint, check;
};
constexpr SameRule kSame[] = {
    {Rule::GOV001, Rule::DOC037},  {Rule::GOV004, Rule::DOC037},   {Rule::GOV005, Rule::DOC037},
    {Rule::GOV006, Rule::DOC037},  {Rule::GOV023, Rule::DOC037},   {Rule::GOV024, Rule::DOC037},
    {Rule::GOV003, Rule::DOC050},  {Rule::GOV011, Rule::DOC054},   {Rule::GOV025, Rule::DOC055},
    {Rule::PERM001, Rule::DOC037}, {Rule::PERM004, Rule::DOC037},  {Rule::PERM005, Rule::DOC037},
    {Rule::PERM006, Rule::DOC037}, {Rule::PERM002, Rule::DOC010},  {Rule::PERM003, Rule::DOC042},
    {Rule::PERM010, Rule::DOC043}, {Rule::PERM011, Rule::DOC010},  {Rule::PERM020, Rule::DOC053},
    {Rule::PERM022, Rule::DOC052}, {Rule::PERM023, Rule::DOC051},  {Rule::PERM024, Rule::DOC050},
    {Rule::PERM025, Rule::DOC054}, {Rule::PERM027, Rule::DOC051},  {Rule::PERM032, Rule::DOC064},
    {Rule::PERM033, Rule::DOC066}, {Rule::PERM040, Rule::PERM040},
};

bool was_checked(const Diagnosis& diagnosis, Rule lint) {
  return std::ranges::any_of(kSame, [&](const SameRule& same) {
    return same.lint == lint && std::ranges::find(diagnosis.checks(), same.check, &Check::rule) !=
                                    diagnosis.checks().end();
  });
}

void add(std::vector<Finding> findings, const std::filesystem::path& file, std::string_view about,
         Diagnosis& out) {
  for (auto& finding : findings) {
    if (was_checked(out, finding.rule)) continue;
    finding.document = file;
    out.report({}, std::move(finding), about);
  }
}

}  // namespace

void diagnose_lint(const LoadedFolder& folder, const Settings& settings, Diagnosis& out) {
  const auto* governance = folder.governance.model.get();
  if (governance != nullptr)
    add(lint(*governance, {.domain = settings.domain}), folder.paths.governance, "governance", out);
  if (folder.permissions.model == nullptr) return;
  const PermissionsUse use{.now = settings.now,
                           .certificate = folder.certificate ? &*folder.certificate : nullptr,
                           .governance = governance};
  add(lint(*folder.permissions.model, use), folder.paths.permissions, "permissions", out);
}

}  // namespace ddssec::governance::doctor
