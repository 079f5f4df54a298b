#include "cli/frame/notices.hpp"

#include <algorithm>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/tool_code.hpp"

namespace ddssec::cli {
namespace {

std::vector<Error>& notices() {
  static std::vector<Error> all;
  return all;
}

}  // namespace

void add_notice(Error warning) {
  const auto is_same = [&](const Error& other) {
    return other.code() == warning.code() && other.details().document == warning.details().document;
  };
  if (!std::ranges::any_of(notices(), is_same)) notices().push_back(std::move(warning));
}

void notice_unreadable_lines(const std::filesystem::path& log, const std::vector<int>& lines) {
  constexpr std::size_t kMax = 10;
  if (lines.empty()) return;
  const auto shown = std::min(kMax, lines.size());
  auto found = fmt::format("{} {}", lines.size() == 1 ? "line" : "lines",
                           fmt::join(lines.begin(), lines.begin() + static_cast<int>(shown), ", "));
  if (shown < lines.size()) found += fmt::format(" and {} more", lines.size() - shown);
  add_notice(Error(tool_code::log_line_unreadable,
                   {.document = log, .line = lines.front(), .found = std::move(found)}));
}

std::vector<Error> take_notices() { return std::exchange(notices(), {}); }

void report_notices(Report& report) {
  for (auto& warning : take_notices()) report.errors.push_back(std::move(warning));
}

}  // namespace ddssec::cli
