// Types that idlc cannot describe: it runs forever, or gives up halfway and still reports success.
#pragma once

#include <vector>

#include "idl/nodes.h"

namespace ddssec::idl {

enum class Nesting { fine, recursive, before_definition };

/// Follows a type through sequences, typedefs, forward declarations and members, also into included
/// files. `recursive` if it contains itself or a type that does, and else `before_definition` if it
/// contains a type that is only declared where it is used.
class NestingCheck {
 public:
  Nesting of(const void* type);

 private:
  Nesting of_members(const void* structure);

  std::vector<const void*> open_;  ///< the structs around what is looked at
  std::vector<const void*> fine_;
};

}  // namespace ddssec::idl
