// Generates one C++ header from one IDL file.
#pragma once

#include <vector>

#include "idl/cpp_type.hpp"
#include "idl/nesting.hpp"

namespace ddssec::idl {

/// Writes the generated header of one IDL file.
class Header {
 public:
  /// `root` is the namespace that contains everything, "" or "a::b".
  Header(const tree_state* state, const std::string& root);

  /// Returns the text of the header. It is empty if something was refused, which idlc has reported.
  std::optional<std::string> make();

 private:
  struct Member {
    std::string entry;  ///< in the traits
    std::string name;   ///< in C++
  };
  void definitions(const void* first);
  void definition(const void* node);
  void enumeration(const void* which);
  void structure(const void* which);
  bool accepts(const void* node);
  bool accepts_nesting(const void* structure);
  Member member(const void* member, const void* name);
  void traits(const void* which, const std::vector<Member>& members);
  static std::string layout(const std::string& type, const std::vector<Member>& members);
  std::string type_description(const void* which);
  void aliases(const void* which);
  void constant(const void* which);
  std::string value_text(const void* value, const CppType& type);

  const tree_state* state_;
  const std::string root_;
  Refusals refusals_;
  CppTypes types_;
  NestingCheck nesting_;
  std::string declared_;  ///< text inside the namespaces
  std::string traits_;    ///< text after the namespaces
};

}  // namespace ddssec::idl
