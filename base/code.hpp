// Every reason for which ddssec refuses something. Each has a stable number, a sentence and a hint.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace ddssec {

/// The severity of a code. An event has that of its code.
enum class Severity : std::uint8_t { debug, informational, warning, error, critical };

/// Returns the name of the enumerator, such as "warning".
std::string_view to_string(Severity severity);

/// All reasons. The number of a reason never changes. The lists are in base/codes/*.def, one for
/// each part of the project: X(name, number, severity, "what happened", "what to do about it").
enum class Code : std::int32_t {
#define X(name, number, severity, summary, hint) name = number,
#include "base/codes/all.def"
#undef X
};

/// The hint of codes after which the user has nothing to do. An error's sentence leaves it out.
inline constexpr std::string_view kNoHint = "none is needed";

/// One row of the table of codes.
struct CodeInfo {
  Code code;
  std::string_view name;  ///< as in the enumeration
  Severity severity;
  std::string_view summary;  ///< what happened, without values
  std::string_view hint;     ///< what the user can do about it
};

/// Sorted by number.
std::span<const CodeInfo> all_codes();

/// Returns the row of `code`.
const CodeInfo& info(Code code);

}  // namespace ddssec
