// Maps IDL types to C++ types, together with the bounds that the C++ types do not express.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "idl/nodes.h"

namespace ddssec::idl {

/// Reports what the generator cannot translate, as "FILE:LINE:COLUMN: error: WHAT: TO DO".
class Refusals {
 public:
  explicit Refusals(const tree_state* state) : state_(state) {}
  void refuse(const void* node, const std::string& what, const std::string& to_do);
  bool any() const { return any_; }

 private:
  const tree_state* state_;
  bool any_ = false;
};

/// The type of a member or of an alias.
struct CppType {
  std::string text;
  std::string initial;      ///< for example " = 0"; empty if the type's own default is sufficient
  std::uint32_t bound = 0;  ///< largest number of characters or elements; 0 if unlimited
  std::uint32_t element_bound = 0;  ///< the bound of a sequence's elements
};

/// Finds the C++ types for the types of IDL.
class CppTypes {
 public:
  /// `root` is the namespace that contains everything generated, "" or "a::b".
  CppTypes(const std::string& root, Refusals& refusals)
      : prefix_(root.empty() ? "::" : "::" + root + "::"), refusals_(refusals) {}

  /// Returns the type for `spec`, with the array dimensions of `name` unless that is nullptr.
  CppType of(const void* spec, const void* name);
  /// Returns the qualified name of a declared type, "::root::Module::Name".
  std::string qualified(const void* node) const;

 private:
  CppType scalar(const void* spec);
  CppType sequence(const void* spec);
  CppType alias(const void* name);

  const std::string prefix_;
  Refusals& refusals_;
};

/// Returns the identifier, followed by "_" if it is a C++ keyword.
std::string cpp_name(const void* node);
/// Returns the name as in the IDL, "Module::Name".
std::string scoped_name(const void* node);
/// Returns a C++ literal; empty if the constant has none.
std::optional<std::string> literal_text(const void* constant);

}  // namespace ddssec::idl
