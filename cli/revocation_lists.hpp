// Revocation lists: those that a CA makes, and those in participants' folders.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/ca_folder.hpp"
#include "cli/command.hpp"
#include "cli/transaction.hpp"
#include "pki/crl.hpp"
#include "pki/issue_log.hpp"

namespace ddssec::cli {

/// Every list of a file, in its order; none if there is no such file. Errors: those of read_file
/// and Crl::all_from; crl_malformed if the file holds no list.
Result<std::vector<pki::Crl>> read_crls(const std::filesystem::path& path);

/// The CA's present list: of those in its file that its key signed, the one with the highest number
/// and the latest date. Errors: those of read_crls and read_certificate.
Result<std::optional<pki::Crl>> present_crl(const CaPaths& ca);

/// What the lists in the CA's file name, also one that another key of the CA signed.
/// Errors: those of read_crls, read_certificate and Crl::revoked.
Result<std::vector<pki::Revocation>> listed_revocations(const CaPaths& ca);

/// Whether the CA's present list names everything that its log and the lists in its file say is
/// revoked; it does not if a crash came between the two. Errors: those of listed_revocations.
Result<bool> lists_all(const CaPaths& ca, const pki::IssueLog& log);

/// How long a list holds that a command makes on its way.
inline constexpr int kListDays = 180;

/// How the next list is dated.
enum class ListDate : std::uint8_t {
  after_former,  ///< now, but not before the list that it follows
  now,           ///< whatever the lists before it say, which were made under a clock that was ahead
};

/// The list that follows the CA's present one: everything revoked by the log, by the lists in the
/// CA's file, by newer lists of this CA in its participants' folders (the CA's folder may have come
/// back from a backup) and by the lists in `more`. Its number is higher than all of theirs, and by
/// default it is not dated before the one of them with the highest number: a running participant
/// would not take it. Errors: those of read_crls and Authority::make_crl; crl_signature_invalid for
/// a list of `more` that the CA did not sign.
Result<pki::Crl> next_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now, int days,
                          const std::vector<std::filesystem::path>& more = {},
                          ListDate date = ListDate::after_former);

/// A list's number, for a person and for JSON (a string where it has more than 64 bits); 0 if it
/// has none.
std::string number_text(const pki::Crl& list);
Json number_json(const pki::Crl& list);

/// The same, for kListDays; but a list that names nothing holds as long as the CA, so that it need
/// not be renewed before a certificate is revoked.
Result<pki::Crl> routine_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now);

/// A new CA's list, which names nothing and holds as long as the CA. Errors: those of make_crl.
Result<pki::Crl> first_crl(const pki::Authority& ca);

/// Lines for a person about a list that is dated after `now`; empty if it is not. `ca`: the CA's
/// folder as the command line has it.
std::string about_clock(const pki::Crl& crl, WallTime now, const std::string& ca);

/// What to do about a list that was made under a clock that was ahead.
std::string way_out_of_the_future(const std::string& ca);

/// For a participant that is made now: the newest list of the CA, from its own folder or from those
/// of its participants on this machine (the CA's may have come back from a backup); nothing if
/// there is none or it is over. Errors: those of present_crl, read_issue_log and
/// participant_places.
Result<std::optional<pki::Crl>> list_for_newcomers(const CaPaths& paths, WallTime now);

/// A list on its way into a participant's folder.
struct ListForFolder {
  const pki::Crl& list;
  const pki::Certificate& ca;             ///< whose list it is
  std::string ca_folder;                  ///< as the command line has it, for hints
  const pki::Certificate* participant;    ///< the certificate of the folder; null: not known
  std::vector<pki::Certificate> trusted;  ///< the participant's identity CAs
  WallTime now;
};

/// Drafts a participant's crl.pem: the list in place of this CA's former one. Lists of other
/// trusted CAs stay, also of a CA with the same name and another key, the list of the participant's
/// own CA being the first. Every command that writes a list into a participant's folder does it
/// here, and has the CA to itself (lock_records) or looks at the CA's list once more afterwards, so
/// that no newer list is lost. Errors: issuer_unknown if the CA is not above the participant;
/// crl_older if the list that is there is newer or names more; crl_missing if there would be no
/// list of the CA that issued the certificate, so that no peer would be authenticated; those of
/// read_file and Replacement::put.
Status put_list(Replacement& out, const std::filesystem::path& file, const ListForFolder& what);

}  // namespace ddssec::cli
