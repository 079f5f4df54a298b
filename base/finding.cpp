#include "base/finding.hpp"

#include <array>

namespace ddssec {
namespace {

// The last row is a sentinel, so that the table is never empty.
constexpr std::array kRules = {
#define X(id, severity, title, hint) RuleInfo{Rule::id, #id, Severity::severity, title, hint},
#include "base/rules/all.def"
#undef X
    RuleInfo{Rule::end_, "", Severity::error, "", ""},
};

}  // namespace

std::span<const RuleInfo> all_rules() { return std::span(kRules).first(kRules.size() - 1); }

const RuleInfo& info(Rule rule) { return kRules.at(static_cast<std::size_t>(rule)); }

}  // namespace ddssec
