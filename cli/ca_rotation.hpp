// A new CA and key in place of an old one, and everything that the old one issued or signed issued
// or signed anew: the same for ROS 2's keystores as for participants' folders.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "cli/ca_folder.hpp"
#include "cli/command.hpp"
#include "cli/transaction.hpp"
#include "pki/participant_folder.hpp"

namespace ddssec::cli {

/// A participant whose files go with the CA. Links among them stay as they are: what they lead to
/// is replaced where it lies.
struct Follower {
  std::string name;  ///< as reports call it
  pki::ParticipantFolder files;
  bool is_named = false;  ///< on the command line, so that it may have moved
};

/// Which CA is replaced, and by which.
struct Succession {
  const OpenCa& old;
  const pki::Authority& ca;
  std::string trust_pem;              ///< what participants are given of `ca`
  const pki::Passphrase* passphrase;  ///< of the new key; null: it is not encrypted
  bool takes_unlogged = false;        ///< also what the old CA's log does not have
};

/// What became of the followers, by their names.
struct Followed {
  std::vector<std::string> again;     ///< have new files
  std::vector<std::string> revoked;   ///< left as they are
  std::vector<Error> doubtful;        ///< left as they are: not what the log has for the folder
  std::vector<Error> unwritten = {};  ///< left as they are: their folders take no files
  std::vector<std::string> unlogged = {};  ///< documents signed although the log lacks them
};

/// Puts the new CA in place, and then the files of each follower. One whose files cannot be put in
/// place moves from `again` to `unwritten`: the next rotation takes it along, since the log vouches
/// for what it has. Errors: those of Replacement::commit, for the CA's own files.
Result<std::vector<WrittenFile>> put_in_place(Replacement& out, Followed& followed);

/// Reports the followers that were left as they are.
void add_left(const Followed& followed, Report& report);

/// The life of a CA that begins now and lasts as long as `old` did.
pki::Validity life_like(const pki::Certificate& old, WallTime now);

/// A new root: the old CA's kind of key and length of life. Errors as Authority::create_root.
Result<pki::Authority> new_root(const pki::Certificate& old, const std::string& subject,
                                const Context& context);

/// Drafts the new permissions CA, and every document of the followers and of `shared` signed anew;
/// then writes the log. Only what the old CA signed and its log has is signed: the old key may be
/// in other hands. A follower with any other document is left as it is. The caller has the CA to
/// itself (lock_records). Errors: those of document_of() for a shared document; the first of
/// `doubtful` and `unwritten` if no follower is left.
Result<Followed> follow_permissions_ca(Replacement& out, const Succession& change,
                                       const std::vector<Follower>& followers,
                                       const std::vector<std::filesystem::path>& shared,
                                       const Context& context);

/// Those of the followers that have a document or a certificate of another permissions CA than the
/// one of `trust_pem`, which is in place: an earlier command could not write their files.
std::vector<Follower> left_with_another_ca(const std::vector<Follower>& followers,
                                           std::string_view trust_pem, WallTime now);

/// As follow_permissions_ca() for followers that were left behind: `change.ca` is in place already,
/// and nothing is written for the CA itself or for `shared`.
Result<Followed> follow_present_permissions_ca(Replacement& out, const Succession& change,
                                               const std::vector<Follower>& followers,
                                               const std::vector<std::filesystem::path>& shared,
                                               const Context& context);

/// Drafts the new identity CA with its revocation list, and the followers' certificates with the
/// same subject, key and end; then writes the log. Only what the log has is issued anew, with this
/// serial number and SHA-256 and for this folder: the old key may be in other hands. A participant
/// that is revoked gets none. The caller has the CA to itself (lock_records). Errors: the first of
/// `doubtful` (issuer_unknown: a certificate that the old CA did not issue) and `unwritten` if
/// nothing is left to issue; those of Authority::reissue.
Result<Followed> follow_identity_ca(Replacement& out, const Succession& change,
                                    const std::vector<Follower>& followers, const Context& context);

}  // namespace ddssec::cli
