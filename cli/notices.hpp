// Warnings that arise far below a command and that its report shows, whatever becomes of it.
#pragma once

#include <filesystem>
#include <vector>

#include "cli/report.hpp"

namespace ddssec::cli {

/// Keeps a warning for the report of this run; the same one of the same document once.
void add_notice(Error warning);
/// Notices the lines of a CA's log that could not be read: log_line_unreadable, once for each log.
void notice_unreadable_lines(const std::filesystem::path& log, const std::vector<int>& lines);
/// Moves what was noticed into the report.
void report_notices(Report& report);

}  // namespace ddssec::cli
