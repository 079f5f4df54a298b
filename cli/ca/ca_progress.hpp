// Reads the progress of a CA's rotation from the files in the participants' folders.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/ca/affected_participants.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/frame/fields.hpp"
#include "pki/issue_log.hpp"

namespace ddssec::cli {

/// Judges folders by the CA's own files. A folder with a file that cannot be read counts as not
/// done.
class RotationProgress {
 public:
  /// Reads the CA's files. Errors: those of read_overlap, read_certificates and read_issue_log.
  static Result<RotationProgress> of(const std::filesystem::path& given, const std::string& role,
                                     WallTime now);

  /// Returns the overlap that is under way, if there is one.
  const std::optional<CaOverlap>& overlap() const { return overlap_; }
  /// Returns the CA's file after the end of the overlap. The CA's own certificate is the first.
  const std::vector<pki::Certificate>& next() const { return next_; }

  /// Returns the participants whose CA file lacks the CA or, during an overlap, its successor.
  std::vector<AffectedParticipant> without_successor(
      const std::vector<AffectedParticipant>& participants) const;
  /// Returns the participants with a certificate or documents that the CA's present key did not
  /// issue or sign.
  std::vector<AffectedParticipant> not_moved(
      const std::vector<AffectedParticipant>& participants) const;
  /// Returns the participants that trust a former CA of the same name, or that trust this one and
  /// have not moved. A participant of a CA with another name is not among them.
  std::vector<AffectedParticipant> not_ended(
      const std::vector<AffectedParticipant>& participants) const;
  /// Returns the participants that are revoked, and so get no certificate of the successor. Empty
  /// for a permissions CA.
  std::vector<AffectedParticipant> revoked(
      const std::vector<AffectedParticipant>& participants) const;

 private:
  bool accepts_successor(const AffectedParticipant& participant) const;
  bool has_moved(const AffectedParticipant& participant) const;
  bool trusts_former(const AffectedParticipant& participant) const;
  bool is_revoked(const AffectedParticipant& participant) const;
  bool is_same_ca(const pki::Certificate& other) const;
  const std::filesystem::path& ca_file(const AffectedParticipant& participant) const;

  CaPaths paths_;
  bool is_identity_ = false;
  WallTime now_;
  pki::IssueLog log_;
  std::optional<CaOverlap> overlap_;
  std::vector<pki::Certificate> next_;
};

/// Returns the folders that the last end of a rotation did not find and that are still not on this
/// machine.
std::vector<std::string> not_reached(const CaPaths& ca, const AffectedParticipants& known);

/// Returns a text such as "1 of 4 folders has moved".
std::string moved_words(std::size_t moved, std::size_t all);

/// Returns the command that distributes the entries that `--move` added to the renewal lists of the
/// CAs, so that `--end` ends no session of Cyclone DDS. Empty if the CA at `given` has no
/// revocation list, because it then cannot distribute lists.
std::string distribution_before_end(const std::filesystem::path& given);

/// The rotation of a CA as `ca show` reports it.
struct RotationFacts {
  static constexpr std::string_view kDef = "ca_rotation";
  std::optional<WallTime> until = {};
  std::vector<std::string> former = {};
  std::size_t folders = 0;
  std::vector<std::string> left = {}, elsewhere = {};
  std::size_t unfinished = 0;  ///< folders, here and elsewhere; only without an overlap
  std::string next = {};       ///< the next step: complete lines
  std::size_t revoked = 0;     ///< folders that are not counted in `folders`

  static constexpr auto fields() {
    return std::tuple(
        field<&RotationFacts::until>({"null: the former CA has ended"}),
        field<&RotationFacts::former>({.note = "SHA-256 of each former CA", .def = "sha256"}),
        field<&RotationFacts::folders>({"how many, without revoked ones"}),
        field<&RotationFacts::left>(
            {.note = "those that have not moved; after the end, those that still have or trust "
                     "something of the former CA",
             .def = "path"}),
        field<&RotationFacts::elsewhere>());
  }
  std::string text() const;
};
/// Returns the state of the rotation. Empty if no overlap is under way and no folder is left.
/// Errors: those of RotationProgress::of and affected_participants.
Result<std::optional<RotationFacts>> shown_rotation(const std::filesystem::path& given,
                                                    const std::string& role, WallTime now);

}  // namespace ddssec::cli
