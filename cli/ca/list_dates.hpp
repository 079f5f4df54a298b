// Checks that the date of a revocation list is plausible. A list from the future cannot be used,
// and no later list with an earlier date can replace it.
#pragma once

#include <chrono>

#include "cli/ca/ca_folder.hpp"

namespace ddssec::cli {

/// For how long a CA may be unused before a command asks whether the clock is right.
inline constexpr std::chrono::days kMaxRest{400};

inline constexpr Option kClockIsRight{
    "--clock-is-right", "",
    "go on although the CA's files know of nothing in the 400 days before now"};

/// Success unless `date` is more than kMaxRest after the latest time that the CA's files show: its
/// certificate, the lines of its log, its lists, and the times at which the files with its
/// certificate and its participants' certificates were written. Entries of the log and lists dated
/// `date` or later do not count. Always success with --clock-is-right. Errors: crl_not_yet_valid;
/// those of read_certificate, read_issue_log, read_crls and participant_places.
Status check_list_date(WallTime date, const CaPaths& ca, const Arguments& arguments);

}  // namespace ddssec::cli
