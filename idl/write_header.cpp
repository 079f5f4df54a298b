#include "idl/write_header.h"

#include <filesystem>
#include <fstream>

#include "idl/header.hpp"

namespace ddssec::idl {
namespace {

bool write(const tree_state* state, const char* root, const char* folder) {
  const auto text = Header(state, root).make();
  if (!text) return false;
  auto path = std::filesystem::path(tree_file(state)).filename();
  path.replace_extension(".hpp");
  if (folder != nullptr) path = std::filesystem::path(folder) / path;
  std::ofstream out(path, std::ios::binary);
  out << *text;
  out.close();
  if (!out)
    tree_error(state, nullptr,
               (path.string() + " cannot be written: is its folder there?").c_str());
  return out.good();
}

}  // namespace
}  // namespace ddssec::idl

// No exception may reach the C code.
extern "C" bool write_header(const tree_state* state, const char* root, const char* folder) {
  try {
    return ddssec::idl::write(state, root, folder);
  } catch (...) {
    return false;
  }
}
