// The files that a rotation of a CA drafts for the CA itself and for its participants.
#pragma once

#include <filesystem>
#include <string>

#include "cli/ca/ca_rotation.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/frame/progress.hpp"

namespace ddssec::cli {

/// True for the steps of an overlap in which running sessions continue with the new certificates
/// and documents. After RotationStep::replace, for a stolen key, all sessions restart.
bool is_moving(const CaRotation& change);

/// Drafts the key, the certificate and the record of the overlap of the CA itself, as far as the
/// step changes them. Errors: those of PrivateKey::to_pem and FileTransaction::put.
Status put_ca(FileTransaction& out, const CaRotation& change);

/// True if the file exists and is no symbolic link. Links stay unchanged, and missing files are not
/// created. Also true for a folder; putting the file then fails.
bool is_to_be_replaced(const std::filesystem::path& path);

/// Drafts the file if is_to_be_replaced(). Errors: those of FileTransaction::put.
Status put_if_there(FileTransaction& out, const std::filesystem::path& file,
                    const std::string& text);

/// Returns a result without participants, with the hint of the step.
RotationResult empty_result(const CaRotation& change);

/// Drafts the files of the participants one after the other: all files of a participant, or none.
class ParticipantDrafts {
 public:
  /// Shows the progress of `participants` calls of add().
  ParticipantDrafts(FileTransaction& out, RotationResult& rotation, std::size_t participants)
      : out_(out), rotation_(rotation), progress_("participants", participants) {}

  /// Runs `draft`, which puts the files of a participant, and records its error in the result. Only
  /// interrupted is returned.
  template <class DraftFiles>
  Status add(const AffectedParticipant& participant, DraftFiles draft) {
    progress_.step();
    out_.begin_folder(participant.name);
    Status drafted = hold_folder(participant.files.folder);
    if (drafted) drafted = draft();
    return note(participant, drafted);
  }

  /// Success if at least one participant was updated, or if none failed. Errors: the first of
  /// RotationResult::doubtful and RotationResult::unwritten.
  Status check() const;

 private:
  Status note(const AffectedParticipant& participant, const Status& drafted);

  FileTransaction& out_;
  RotationResult& rotation_;
  Progress progress_;
};

/// Adds the hint about a participant that keeps its old files, unless the error has its own hint.
Error with_unwritten_hint(const Error& error, const std::string& unwritten_hint);

}  // namespace ddssec::cli
