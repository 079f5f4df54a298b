// Detects types that idlc cannot describe: it would run forever, or stop halfway and still report
// success.
#pragma once

#include <vector>

#include "idl/nodes.h"

namespace ddssec::idl {

enum class Nesting { fine, recursive, before_definition };

/// Follows a type through sequences, typedefs, forward declarations and members, including those in
/// included files. Returns `recursive` if the type contains itself or a type that does. Otherwise
/// returns `before_definition` if it contains a type that is only declared, not yet defined, where
/// it is used.
class NestingCheck {
 public:
  Nesting of(const void* type);

 private:
  Nesting of_members(const void* structure);

  std::vector<const void*> open_;  ///< the structs around the current one
  std::vector<const void*> fine_;
};

}  // namespace ddssec::idl
