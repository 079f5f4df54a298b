// Replaces a CA and its key. Everything that the old CA issued or signed is issued or signed again.
// Handles ROS 2 keystores and participants' folders alike.
#pragma once

#include <string>
#include <vector>

#include "cli/ca/ca_folder.hpp"
#include "cli/ca/ca_overlap.hpp"
#include "cli/frame/command.hpp"
#include "cli/frame/file_transaction.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// A participant whose files change with the CA. Its symbolic links stay: a CA file, revocation
/// list or governance document behind a link is not changed, and a participant whose certificate or
/// permissions are a link is left unchanged.
struct AffectedParticipant {
  std::string name;  ///< its name in reports
  pki::ParticipantFolder files;
  bool is_named = false;  ///< named on the command line, so it may have been moved
};

/// One step of a rotation.
enum class RotationStep : std::uint8_t {
  replace,  ///< replaces the CA and everything that it signed, at once
  begin,    ///< begins an overlap: the CA gets its successor, and participants accept both
  move,     ///< participants get certificates and documents of the successor, and accept both
  end,      ///< as `move` for those that have not moved; then all accept only the successor
};

/// The CA whose files are in place, and its successor.
struct CaRotation {
  const OpenCa& ca_in_place;  ///< the old CA; from RotationStep::move on the successor
  const pki::Authority& ca;
  std::string trust_pem;              ///< the CA file of the participants
  const pki::Passphrase* passphrase;  ///< for the new key; nullptr: the key is not encrypted
  bool takes_unlogged = false;        ///< also handle what the old CA's log does not contain
  RotationStep step = RotationStep::replace;
  std::optional<CaOverlap> overlap = {};  ///< set for every step except RotationStep::replace
  /// True if the step is repeated for participants that it did not reach: nothing is written for
  /// the CA itself.
  bool is_repeated = false;
  std::string unwritten_hint = {};  ///< RotationResult::unwritten_hint; empty: the default
};

/// The outcome for each participant, by name.
struct RotationResult {
  std::vector<std::string> updated;  ///< participants that have new files
  std::vector<std::string> revoked;  ///< participants left as they are
  /// Participants left unchanged because their files differ from what the log contains for the
  /// folder.
  std::vector<Error> doubtful;
  /// Participants left unchanged because their folders cannot be written.
  std::vector<Error> unwritten = {};
  std::vector<std::string> unlogged = {};  ///< documents signed although the log lacks them
  /// The hint for a participant whose folder cannot be written: what that means and what to do.
  std::string unwritten_hint =
      "the participant keeps its old files and authenticates no other one until it has new ones; "
      "make its "
      "folder writable, then rotate the CA once more";
};

/// Puts the new CA in place, and then the files of each participant. A participant whose files
/// cannot be put in place moves from `updated` to `unwritten`. The next rotation includes it,
/// because the log has recorded its files. Errors: those of FileTransaction::commit for the CA's
/// own files.
Result<std::vector<WrittenFile>> put_in_place(FileTransaction& out, RotationResult& rotation);

/// Reports the participants that were left unchanged.
void add_unreached(const RotationResult& rotation, Report& report);

/// Returns a validity that begins now and lasts as long as that of `old`.
pki::Validity validity_like(const pki::Certificate& old, WallTime now);

/// Creates a root with the same kind of key as the old CA, and the same length of validity. Errors:
/// those of Authority::create_root.
Result<pki::Authority> new_root(const pki::Certificate& old, const std::string& subject,
                                const Context& context);

}  // namespace ddssec::cli
