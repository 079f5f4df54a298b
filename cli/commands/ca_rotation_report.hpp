// What `ca rotate` answers: the result, the next step, and hints for participants that stay behind.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cli/ca/affected_participants.hpp"
#include "cli/ca/ca_rotation.hpp"
#include "cli/commands/ca_results.hpp"

namespace ddssec::cli {

/// Returns the result for a CA of the folder; `step` is the word for what was done, `overlap` the
/// overlap that is under way.
RotatedCa rotated(const std::string& role, std::string_view step, const pki::Certificate& ca,
                  const std::optional<CaOverlap>& overlap);

/// Returns the answer for a step that was taken. `elsewhere` names the participants whose folders
/// are on other machines, `given` is the folder on the command line.
Answer<RotatedCa> answer_of(const std::string& role, const CaRotation& change,
                            const RotationResult& rotation,
                            const std::vector<std::string>& elsewhere, const std::string& given);

/// Returns the hint for a participant whose folder cannot be written: what that means and what to
/// do.
std::string unwritten_hint(const std::string& role, RotationStep step, const std::string& given);

/// Reports participants that have new files but run without taking them.
void add_not_taken(const std::string& role, const std::vector<AffectedParticipant>& participants,
                   const RotationResult& rotation, Report& report);

}  // namespace ddssec::cli
