// Revocation lists, both those that a CA makes and those in participants' folders.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "cli/ca/ca_folder.hpp"
#include "cli/frame/command.hpp"
#include "cli/frame/file_transaction.hpp"
#include "pki/crl.hpp"
#include "pki/issue_log.hpp"

namespace ddssec::cli {

/// Reads all lists of a file, in its order; empty if the file does not exist. Errors: those of
/// read_file and Crl::all_from; crl_malformed if the file contains no list.
Result<std::vector<pki::Crl>> read_crls(const std::filesystem::path& path);

/// Reads the CA's present list: among the lists in its file that its key signed, the one with the
/// highest number and the latest date. Errors: those of read_crls and read_certificate.
Result<std::optional<pki::Crl>> present_crl(const CaPaths& ca);

/// Reads all revocations in the lists in the CA's file, including lists that another key of the CA
/// signed. Errors: those of read_crls, read_certificate and Crl::revoked.
Result<std::vector<pki::Revocation>> listed_revocations(const CaPaths& ca);

/// True if the CA's present list contains all revocations in its log and in the lists in its file.
/// False if a crash came after the log was written and before the list was. Errors: those of
/// listed_revocations.
Result<bool> lists_all(const CaPaths& ca, const pki::IssueLog& log);

/// The validity, in days, of a list that another command makes besides its own task.
inline constexpr int kListDays = 180;

/// The way in which the next list is dated.
enum class ListDate : std::uint8_t {
  after_former,  ///< now, but not before the former list
  now,  ///< now, even if former lists are later because they were made with a clock that was ahead
};

/// Makes the list that follows the CA's present one. It contains all revocations in the log, in the
/// lists in the CA's file, in newer lists of this CA in its participants' folders (the CA's folder
/// may have been restored from a backup) and in the lists in `more`. Its number is higher than all
/// of theirs. By default it is not dated before the one of them with the highest number, because a
/// running participant would not accept it. Errors: those of read_crls and Authority::make_crl;
/// crl_signature_invalid for a list of `more` that the CA did not sign.
Result<pki::Crl> next_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now, int days,
                          const std::vector<std::filesystem::path>& more = {},
                          ListDate date = ListDate::after_former);

/// Returns a list's number; 0 if it has none.
std::string number_text(const pki::Crl& list);

/// A list's number as a field of a result.
struct ListNumber {
  static constexpr std::string_view kDef = "crl_number";
  std::string text;
  std::optional<std::uint64_t> small;  ///< empty: the number has more than 64 bits

  static ListNumber of(const pki::Crl& list) {
    return {number_text(list), list.number().value_or(0).as_uint64()};
  }
  Json json() const { return small ? Json(*small) : Json(text); }
};

/// Makes the next list with a validity of kListDays. A list without entries is valid as long as the
/// CA, so it need not be renewed before a certificate is revoked.
Result<pki::Crl> routine_crl(const OpenCa& ca, const pki::IssueLog& log, WallTime now);

/// Makes a new CA's list, without entries and valid as long as the CA. Errors: those of make_crl.
Result<pki::Crl> first_crl(const pki::Authority& ca);

/// Returns lines of text about a list that is dated after `now`. Empty if it is not. `ca` is the
/// CA's folder as on the command line.
std::string list_date_warning(const pki::Crl& crl, WallTime now, const std::string& ca);

/// Returns the hint for a list that was made with a clock that was ahead.
std::string future_list_hint(const std::string& ca);

/// Returns the list for a new participant: the newest list of the CA, from its own folder or from
/// those of its participants on this machine (the CA's may have been restored from a backup). Empty
/// if there is none or it has expired. Errors: those of present_crl, read_issue_log and
/// participant_places.
Result<std::optional<pki::Crl>> list_for_newcomers(const CaPaths& paths, WallTime now);

/// A list to be put into a participant's folder.
struct ListForFolder {
  const pki::Crl& list;
  const pki::Certificate& ca;             ///< the CA that made the list
  std::string ca_folder;                  ///< as on the command line, for hints
  const pki::Certificate* participant;    ///< in the folder; nullptr: not known
  std::vector<pki::Certificate> trusted;  ///< the participant's identity CAs
  WallTime now;
  /// Further lists to put there, of CAs among `trusted`.
  std::vector<pki::Crl> beside = {};
};

/// Drafts a participant's crl.pem, in which the list replaces this CA's former one. Lists of other
/// trusted CAs stay, including those of a CA with the same name and another key. The list of the
/// participant's own CA comes first.
///
/// Every command that writes a list into a participant's folder uses this function. It holds the
/// CA's lock (lock_records), or checks the CA's list once more afterwards, so that no newer list is
/// lost.
///
/// Errors: issuer_unknown if the CA is not above the participant and not among those that it
/// trusts; crl_older if the existing list is newer or contains more; crl_missing if there would be
/// no list of the CA that issued the certificate, so that no peer would be authenticated; those of
/// read_file and FileTransaction::put.
Status put_list(FileTransaction& out, const std::filesystem::path& file, const ListForFolder& what);

}  // namespace ddssec::cli
