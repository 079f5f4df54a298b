#include "cli/commands/ca_rotation_report.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "cli/participant/running_participant.hpp"

namespace ddssec::cli {
namespace {

std::string_view step_word(RotationStep step) {
  switch (step) {
    case RotationStep::replace:
      return "replaced";
    case RotationStep::begin:
      return "begun";
    case RotationStep::move:
      return "moved";
    case RotationStep::end:
      return "ended";
  }
  return "";
}

std::string next_step(const std::string& role, RotationStep step, const std::string& given) {
  const auto command = fmt::format("ddssec ca rotate {} --role {}", given, role);
  switch (step) {
    case RotationStep::replace:
      break;
    case RotationStep::begin:
      return fmt::format(
          "Participants on ddssec's plugins take the files while they run. When all have them, "
          "those on other machines too: {} --move\n"
          "With stock plugins, restart a participant after it was moved. Until then it talks only "
          "to those that have not moved: ddssec check A B\n",
          command);
    case RotationStep::move: {
      const auto lists = distribution_before_end(given);
      return fmt::format("{}When all have moved{}, those on other machines too: {} --end\n",
                         lists.empty() ? ""
                                       : fmt::format("Next, so that --end ends no session of "
                                                     "Cyclone DDS: {}\n",
                                                     lists),
                         lists.empty() ? "" : " and have renewed.pem", command);
    }
    case RotationStep::end:
      return "Copy the folders of participants on other machines there. Sessions of Cyclone DDS "
             "that began with the former CA end and begin again, unless both sides have "
             "renewed.pem.\n";
  }
  return "Every participant must start again with the new files, unless it runs on ddssec's "
         "plugins: "
         "old ones and new ones do not authenticate each other.\n";
}

}  // namespace

RotatedCa rotated(const std::string& role, std::string_view step, const pki::Certificate& ca,
                  const std::optional<CaOverlap>& overlap) {
  RotatedCa out{.role = role,
                .step = std::string(step),
                .until = {},
                .subject = ca.subject(),
                .not_after = ca.not_after(),
                .sha256 = to_hex(ca.fingerprint())};
  if (overlap) out.until = overlap->until;
  return out;
}

Answer<RotatedCa> answer_of(const std::string& role, const CaRotation& change,
                            const RotationResult& rotation,
                            const std::vector<std::string>& elsewhere, const std::string& given) {
  Answer<RotatedCa> out{
      rotated(role, step_word(change.step), change.ca.certificate(), change.overlap)};
  auto& [result, report, has_result] = out;
  result.folders = rotation.updated;
  result.revoked = rotation.revoked;
  result.unlogged = rotation.unlogged;
  result.elsewhere = elsewhere;
  add_unreached(rotation, report);
  for (const auto& name : elsewhere)
    report.errors.emplace_back(Code::participant_elsewhere, ErrorDetails{.found = name});
  report.text += next_step(role, change.step, given);
  if (role == "permissions" && change.step == RotationStep::replace)
    report.text += "A signed document that lies elsewhere is still the old CA's: sign it again.\n";
  return out;
}

std::string unwritten_hint(const std::string& role, RotationStep step, const std::string& given) {
  const auto command = fmt::format("ddssec ca rotate {} --role {}", given, role);
  const auto again = "make its folder writable, then: " + command;
  switch (step) {
    case RotationStep::replace:
      break;
    case RotationStep::begin:
      return fmt::format(
          "the participant keeps its old files, and does not accept those that move before it has "
          "the successor; {} --overlap TIME",
          again);
    case RotationStep::move:
      return fmt::format("the participant keeps its old files, which count until --end; {} --move",
                         again);
    case RotationStep::end:
      return fmt::format(
          "the participant keeps its old files, and still trusts the former CA; {} "
          "--end",
          again);
  }
  return fmt::format(
      "the participant keeps its old files and authenticates no other one until it has new ones; "
      "{} --end",
      again);
}

void add_not_taken(const std::string& role, const std::vector<AffectedParticipant>& participants,
                   const RotationResult& rotation, Report& report) {
  for (const auto& participant : participants) {
    if (std::ranges::find(rotation.updated, participant.name) == rotation.updated.end()) continue;
    const auto certificate = read_certificate(participant.files.certificate);
    const auto problem = role == "permissions" ? permissions_not_there(participant.files)
                         : certificate         ? key_not_there(participant.files, *certificate)
                                               : std::nullopt;
    if (problem) report.errors.push_back(*problem);
  }
}

}  // namespace ddssec::cli
