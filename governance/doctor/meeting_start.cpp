// Predicts how each of two participants starts on its own.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "governance/doctor/checks.hpp"
#include "governance/doctor/meeting_steps.hpp"

namespace ddssec::governance::doctor {
namespace {

std::string files_missing(const LoadedFolder& folder) {
  return fmt::format("{} holds none of the files of a secured participant",
                     folder.paths.folder.string());
}

// True if the check concerns single topics or peers: the participant starts and uses the others.
bool is_about_some(const Check& check, Product product) {
  return check.outcomes.of(product) == Outcome::late &&
         (check.rule == Rule::DOC052 || check.rule == Rule::DOC053 || check.rule == Rule::DOC109 ||
          check.rule == Rule::DOC110);
}

// A finding of the party's own diagnosis that prevents its start.
const Finding* first_obstacle(const Diagnosis& diagnosis, Product product) {
  for (const auto& check : diagnosis.checks())
    if (check.outcomes.of(product) >= Outcome::late && !check.findings.empty() &&
        !is_about_some(check, product))
      return &check.findings.front();
  return nullptr;
}

// If only the CA's own list revokes a participant, its peers accept it until they get the list.
void note_revocation(const MeetingScene& scene, const Party& party, const Diagnosis& diagnosis) {
  for (const auto& check : diagnosis.checks()) {
    if (check.rule != Rule::DOC024 || check.outcomes.of(party.product) != Outcome::unsafe) continue;
    for (auto finding : check.findings) {
      finding.message = fmt::format("{}: {}", party.name, finding.message);
      finding.severity = Severity::warning;
      scene.out.notes.push_back(std::move(finding));
    }
  }
}

bool is_about_fastdds(const Finding& finding) {
  return std::filesystem::path(finding.document).filename() == "fastdds.xml";
}

// Notes findings about places that can be judged only on the machine where the participant runs.
void note_places(const MeetingScene& scene, const Party& party, const Diagnosis& diagnosis) {
  for (const auto& check : diagnosis.checks()) {
    if (check.rule != Rule::DOC007) continue;
    for (auto finding : check.findings) {
      if (is_about_fastdds(finding) != (party.product == Product::fastdds)) continue;
      finding.message = fmt::format("{}: {}", party.name, finding.message);
      finding.products.clear();
      scene.out.notes.push_back(std::move(finding));
    }
  }
}

}  // namespace

void diagnose_start(const MeetingScene& scene, int index) {
  const auto& party = scene.party(index);
  const auto& folder = party.folder;
  PartyDecision out{.judge = index, .about = index, .ok = true};
  if (folder.is_empty()) {
    const auto& other = scene.party(1 - index);
    out.ok = false;
    out.reason = "has no security";
    out.document = folder.paths.folder.string();
    scene.out.start.push_back(out);
    return add_finding(scene, Rule::DOC087, out,
                       fmt::format("{}: {} runs without security and {} with it; neither would see "
                                   "the other, and neither would say so",
                                   files_missing(folder), party.name, other.name));
  }
  auto settings = scene.settings;
  settings.lineup = party.lineup;
  const auto diagnosis = diagnose(folder, settings);
  if (const auto* why = first_obstacle(diagnosis, party.product)) {
    out.ok = false;
    out.reason = fmt::format("{}: {}", info(why->rule).id, why->message);
    out.document = why->document;
    out.line = why->line;
    add_finding(scene, Rule::DOC090, out,
                fmt::format("{} cannot start on its own with {}: {}", party.name,
                            party.product_name(), out.reason),
                why->hint.empty() ? std::string(info(why->rule).hint) : why->hint);
  }
  note_revocation(scene, party, diagnosis);
  if (settings.may_run_elsewhere) note_places(scene, party, diagnosis);
  scene.out.start.push_back(out);
}

}  // namespace ddssec::governance::doctor
