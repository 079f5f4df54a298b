// Finds the shared libraries that a shared library depends on.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ddssec::governance::doctor {

/// The contents of the dynamic section of a 64-bit ELF file. Nothing is loaded.
struct NeededLibraries {
  std::vector<std::string> names = {};  ///< DT_NEEDED, such as libsodium.so.23
  std::string search_path = {};         ///< DT_RUNPATH or DT_RPATH; may contain $ORIGIN
};
/// Reads the dynamic section. The result is empty for octets of any other form.
NeededLibraries needed_libraries(std::string_view octets);

}  // namespace ddssec::governance::doctor
