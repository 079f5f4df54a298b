// explain: what a code means and what to do about it.
#include <algorithm>

#include <fmt/format.h>

#include "cli/groups.hpp"

namespace ddssec::cli {

Result<Report> explain(const Arguments& arguments, const Context&) {
  const auto wanted = arguments.text("CODE");
  const auto row = std::ranges::find_if(all_codes(), [&](const CodeInfo& code) {
    return code.name == wanted || std::to_string(static_cast<int>(code.code)) == wanted;
  });
  if (row == all_codes().end())
    return fail(Code::usage, {.field = "CODE",
                              .expected = "a name or number as messages show it in brackets",
                              .found = '"' + wanted.substr(0, 64) + '"'});
  const auto number = static_cast<int>(row->code);
  return Report{.text = fmt::format("{} {} ({})\n  {}\n  {}\n", row->name, number,
                                    to_string(row->severity), row->summary, row->hint),
                .result = {{"name", row->name},
                           {"number", number},
                           {"severity", to_string(row->severity)},
                           {"summary", row->summary},
                           {"hint", row->hint}}};
}

}  // namespace ddssec::cli
