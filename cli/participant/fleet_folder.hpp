// The output folders for the participants of a fleet.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/ca/certificate_facts.hpp"
#include "cli/frame/new_folder.hpp"
#include "cli/participant/participant.hpp"

namespace ddssec::cli {

/// The output of a command for a fleet: the whole folder, or one folder for each participant that
/// an existing fleet lacks.
class FleetFolder {
 public:
  /// Begins the output. Removes participants from `specs` that already have a certificate there.
  /// Errors: would_overwrite if all of them have one, or if something else has the name of one;
  /// those of NewFolder::at and check_nameable.
  static Result<FleetFolder> at(const std::filesystem::path& target,
                                std::vector<ParticipantSpec>& specs);

  /// Adds the participant of the `index`-th spec. Errors: those of add_flat.
  Status add(std::size_t index, const std::string& name, const NewParticipant& made,
             const Issuers& issuers, BytesView governance);
  /// Puts the folders in place. Those of an existing fleet are committed one by one; if one fails,
  /// repeat the same command to add the rest. Errors: those of NewFolder::commit.
  Result<std::vector<WrittenFile>> commit();

  /// Returns the text about the folders for the report.
  std::string text() const;

 private:
  explicit FleetFolder(std::filesystem::path target) : target_(std::move(target)) {}
  bool has(const ParticipantSpec& spec) const;

  std::filesystem::path target_;
  bool is_growing_ = false;
  std::size_t kept_ = 0;
  std::vector<NewFolder> parts_;
};

/// The result for all participants of a fleet.
struct IssuedFleet {
  static constexpr std::string_view kWhen = "with --from";
  std::filesystem::path dir;
  std::vector<IssuedFacts> participants = {};

  static constexpr auto fields() {
    return std::tuple(field<&IssuedFleet::dir>(),
                      field<&IssuedFleet::participants>(
                          {.note = "each: the same", .has_same_members = true, .min = 1}));
  }
  std::string text() const {
    std::string out;
    for (const auto& one : participants) out += one.text();
    return out;
  }
};

/// The lines of the CAs' logs for the participants of a fleet.
class FleetMembers {
 public:
  /// `permissions` is the permissions CA, or nullptr.
  FleetMembers(const OpenCa* permissions, std::filesystem::path target, WallTime now)
      : permissions_(permissions), target_(std::move(target)), now_(now) {}

  /// Adds the lines of a participant. Returns what the report says about it.
  IssuedFacts add(const std::string& name, const NewParticipant& made);
  const std::string& issued() const { return issued_; }
  const std::string& signed_lines() const { return signed_; }

 private:
  const OpenCa* permissions_;
  std::filesystem::path target_;
  WallTime now_;
  std::string issued_, signed_;
};

}  // namespace ddssec::cli
