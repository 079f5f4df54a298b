#include "idl/nesting.hpp"

#include <algorithm>

namespace ddssec::idl {

Nesting NestingCheck::of(const void* type) {
  switch (tree_kind_of(type)) {
    case tree_sequence:
    case tree_alias:
      return of(tree_type(type));
    case tree_forward: {
      const auto defined = of(tree_definition(type));
      return defined == Nesting::recursive ? defined : Nesting::before_definition;
    }
    case tree_struct:
      return of_members(type);
    default:
      return Nesting::fine;
  }
}

Nesting NestingCheck::of_members(const void* structure) {
  if (std::ranges::find(open_, structure) != open_.end()) return Nesting::recursive;
  if (std::ranges::find(fine_, structure) != fine_.end()) return Nesting::fine;
  open_.push_back(structure);
  auto out = Nesting::fine;
  for (const auto* at = tree_first(structure); at != nullptr; at = tree_next(at)) {
    const auto member = of(tree_type(at));
    if (out != Nesting::recursive && member != Nesting::fine) out = member;
  }
  open_.pop_back();
  if (out == Nesting::fine) fine_.push_back(structure);
  return out;
}

}  // namespace ddssec::idl
