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
  down_ |= mixed || change == ChangeClass::weaker || change == ChangeClass::wider;
  up_ |= mixed || change == ChangeClass::stronger || change == ChangeClass::narrower;
  unknown_ |= change == ChangeClass::unknown;
}

ChangeClass CombinedChange::change_class(ChangeClass if_up, ChangeClass if_down) const {
  // Whatever else there may be, it cannot make this better or worse.
  if (up_ && down_) return ChangeClass::mixed;
  if (unknown_) return ChangeClass::unknown;
  return up_ ? if_up : down_ ? if_down : ChangeClass::neutral;
}

}  // namespace ddssec::governance
