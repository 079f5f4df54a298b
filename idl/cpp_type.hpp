// What an IDL type is in C++ and which bounds the C++ type does not carry.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "idl/nodes.h"

namespace ddssec::idl {

/// How the generator speaks of what it cannot make: "FILE:LINE:COLUMN: error: WHAT: TO DO".
class Refusals {
 public:
  explicit Refusals(const tree_state* state) : state_(state) {}
  void refuse(const void* node, const std::string& what, const std::string& to_do);
  bool any() const { return any_; }

 private:
  const tree_state* state_;
  bool any_ = false;
};

/// A member's or an alias's type.
struct CppType {
  std::string text;
  std::string initial;              ///< " = 0", or empty where the type's own default will do
  std::uint32_t bound = 0;          ///< most characters or elements; 0: any number
  std::uint32_t element_bound = 0;  ///< of a sequence's elements
};

class CppTypes {
 public:
  /// `root`: the namespace that everything generated lies in, "" or "a::b".
  CppTypes(const std::string& root, Refusals& refusals)
      : prefix_(root.empty() ? "::" : "::" + root + "::"), refusals_(refusals) {}

  /// The type that `spec` names, with the dimensions of `name` (nullptr: none).
  CppType of(const void* spec, const void* name);
  /// "::root::Module::Name" of a declared type.
  std::string qualified(const void* node) const;

 private:
  CppType scalar(const void* spec);
  CppType sequence(const void* spec);
  CppType alias(const void* name);

  const std::string prefix_;
  Refusals& refusals_;
};

/// The identifier, with "_" behind it if C++ has it as a keyword.
std::string cpp_name(const void* node);
/// "Module::Name": as the IDL says it.
std::string scoped_name(const void* node);
/// A C++ literal; nothing if it has none.
std::optional<std::string> literal_text(const void* constant);

}  // namespace ddssec::idl
