// Where the participants of one fleet's file go.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/participant.hpp"
#include "cli/transaction.hpp"

namespace ddssec::cli {

/// What a fleet's command writes: the whole folder, or one folder for each participant that a fleet
/// which is there lacks.
class FleetFolder {
 public:
  /// Participants that have a certificate there are taken out of `specs`. Errors: would_overwrite
  /// if all of them have, or if something else has the name of one; those of NewFolder::at.
  static Result<FleetFolder> at(const std::filesystem::path& target,
                                std::vector<ParticipantSpec>& specs);

  /// Puts the participant of the `index`-th spec in. Errors: those of add_flat.
  Status add(std::size_t index, const std::string& name, const NewParticipant& made,
             const Issuers& issuers, BytesView governance);
  /// Errors: those of NewFolder::commit. Folders of a fleet that grows are committed one by one:
  /// the same command adds what an error left out.
  Result<std::vector<WrittenFile>> commit();

  /// What is said of the folders.
  std::string text() const;

 private:
  explicit FleetFolder(std::filesystem::path target) : target_(std::move(target)) {}
  bool has(const ParticipantSpec& spec) const;

  std::filesystem::path target_;
  bool is_growing_ = false;
  std::size_t kept_ = 0;
  std::vector<NewFolder> parts_;
};

/// What the CAs' logs and the report say of the participants of a fleet.
class FleetMembers {
 public:
  /// `permissions`: the permissions CA, or null.
  FleetMembers(const OpenCa* permissions, std::filesystem::path target, WallTime now)
      : permissions_(permissions), target_(std::move(target)), now_(now) {}

  void add(const std::string& name, const NewParticipant& made, Report& report);
  const std::string& issued() const { return issued_; }
  const std::string& signed_lines() const { return signed_; }

 private:
  const OpenCa* permissions_;
  std::filesystem::path target_;
  WallTime now_;
  std::string issued_, signed_;
};

}  // namespace ddssec::cli
