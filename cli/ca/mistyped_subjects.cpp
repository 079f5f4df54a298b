#include "cli/ca/mistyped_subjects.hpp"

#include <algorithm>
#include <iterator>
#include <set>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/ca/ca_folder.hpp"
#include "cli/frame/suggestions.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::cli {
namespace {

// The largest numbers of subjects in the log, and of grants, that are compared with each other.
constexpr std::size_t kMaxSubjects = 5'000, kMaxGrants = 64;

std::string without_digits(std::string_view text) {
  std::string out;
  std::ranges::copy_if(text, std::back_inserter(out),
                       [](const char c) { return c < '0' || '9' < c; });
  return out;
}

// The subjects of all certificates in a CA's log.
struct IssuedSubjects {
  std::set<std::string> keys = {};  // as SubjectName::key
  std::vector<std::string> texts = {};

  bool has(const pki::SubjectName& name) const { return keys.contains(name.key()); }
  std::string similar_to(std::string_view subject) const {
    std::vector<std::string> others;
    for (const auto& text : texts)
      if (without_digits(text) != without_digits(subject)) others.push_back(text);
    return nearest(subject, others);
  }
};

IssuedSubjects issued_subjects(const std::filesystem::path& ca) {
  IssuedSubjects out;
  const auto log = read_issue_log(ca_paths(ca, "identity"));
  if (!log) return out;
  for (const auto& issued : log->issued()) {
    const auto name = pki::SubjectName::parse(issued.subject);
    if (name && out.keys.insert(name->key()).second && out.texts.size() < kMaxSubjects)
      out.texts.push_back(issued.subject);
  }
  return out;
}

}  // namespace

std::vector<Finding> mistyped_subjects(const governance::Permissions& permissions,
                                       const std::filesystem::path& ca,
                                       const std::filesystem::path& file) {
  std::vector<Finding> out;
  const auto issued = issued_subjects(ca);
  std::size_t compared = 0;
  for (const auto& grant : permissions.grants) {
    const auto name = pki::SubjectName::parse(grant.subject_name);
    if (grant.subject_is_expression || !name || issued.has(*name)) continue;
    if (++compared > kMaxGrants || out.size() == kMaxMistypedSubjects) break;
    const auto similar = issued.similar_to(grant.subject_name);
    if (similar.empty()) continue;
    out.push_back({.rule = Rule::DOC010,
                   .message = fmt::format("the CA has issued no certificate for \"{}\", so that no "
                                          "participant can use this grant; is \"{}\" meant?",
                                          grant.subject_name, similar),
                   .document = file.string(),
                   .line = grant.line,
                   .severity = Severity::warning});
  }
  return out;
}

}  // namespace ddssec::cli
