#include "governance/compare/change_class.hpp"

#include <array>

namespace ddssec::governance {

std::string_view to_string(ChangeClass change) {
  constexpr std::array<std::string_view, 8> kNames = {"neutral", "interop", "stronger", "narrower",
                                                      "wider",   "weaker",  "mixed",    "unknown"};
  return kNames.at(static_cast<std::size_t>(change));
}

void CombinedChange::add(ChangeClass change) {
  const bool mixed = change == ChangeClass::mixed;
  loses_ |= mixed || change == ChangeClass::weaker || change == ChangeClass::wider;
  gains_ |= mixed || change == ChangeClass::stronger || change == ChangeClass::narrower;
  is_unknown_ |= change == ChangeClass::unknown;
}

ChangeClass CombinedChange::change_class(ChangeClass if_up, ChangeClass if_down) const {
  // A change that both gains and loses is mixed, whatever the unknown parts are.
  if (gains_ && loses_) return ChangeClass::mixed;
  if (is_unknown_) return ChangeClass::unknown;
  return gains_ ? if_up : loses_ ? if_down : ChangeClass::neutral;
}

}  // namespace ddssec::governance
