// Whether a revocation list is dated at a time that can be true. A list from the future cannot be
// used, and no later list with an earlier date takes its place.
#pragma once

#include <chrono>

#include "cli/ca_folder.hpp"

namespace ddssec::cli {

/// How long a CA may rest before a command asks whether the clock is right.
inline constexpr std::chrono::days kMaxRest{400};

inline constexpr Option kClockIsRight{
    "--clock-is-right", "",
    "go on although the CA's files know of nothing in the 400 days before now"};

/// Success unless `date` is more than kMaxRest after everything that is known of the CA: its
/// certificate, the lines of its log, its lists, and the times at which the files with its
/// certificate and its participants' certificates were written. What the log and the lists say of
/// `date` itself and of later times does not count. Always success with --clock-is-right.
/// Errors: crl_not_yet_valid; those of read_certificate, read_issue_log, read_crls and
/// participant_places.
Status check_list_date(WallTime date, const CaPaths& ca, const Arguments& arguments);

}  // namespace ddssec::cli
