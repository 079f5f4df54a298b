// Warnings from deep inside a command, which its report shows whatever its result is.
#pragma once

#include <filesystem>
#include <vector>

#include "cli/frame/report.hpp"

namespace ddssec::cli {

/// Stores a warning for the report of this run. The same warning about the same document is stored
/// once.
void add_notice(Error warning);
/// Adds a notice about unreadable lines of a CA's log: log_line_unreadable, once for each log.
void notice_unreadable_lines(const std::filesystem::path& log, const std::vector<int>& lines);
/// Removes the notices and returns them.
std::vector<Error> take_notices();
/// Moves the notices into the report.
void report_notices(Report& report);

}  // namespace ddssec::cli
