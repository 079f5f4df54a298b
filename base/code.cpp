#include "base/code.hpp"

#include <algorithm>
#include <array>

namespace ddssec {
namespace {

// std::to_array is used because the deduction guide of std::array would fold over the rows, and
// clang limits a fold to 256.
constexpr auto kUnsorted = std::to_array<CodeInfo>({
#define X(name, number, severity, summary, hint) \
  CodeInfo{Code{number}, #name, Severity::severity, summary, hint},
#include "base/codes/all.def"
#include "base/codes/tool.def"
#undef X
});

constexpr auto kCodes = [] {
  auto rows = kUnsorted;
  std::ranges::sort(rows, {}, &CodeInfo::code);
  return rows;
}();

static_assert(std::ranges::adjacent_find(kCodes, {}, &CodeInfo::code) == kCodes.end(),
              "two codes share one number");

}  // namespace

std::string_view to_string(Severity severity) {
  constexpr std::array<std::string_view, 5> kNames = {"debug", "informational", "warning", "error",
                                                      "critical"};
  return kNames.at(static_cast<std::size_t>(severity));
}

std::span<const CodeInfo> all_codes() { return kCodes; }

const CodeInfo& info(Code code) {
  const auto row = std::ranges::lower_bound(kCodes, code, {}, &CodeInfo::code);
  return row != kCodes.end() && row->code == code ? *row : info(Code::internal);
}

}  // namespace ddssec
