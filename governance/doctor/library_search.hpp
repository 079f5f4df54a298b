// Where the dynamic loader finds a library that is opened by its name alone, as glibc's ld.so looks
// (measured with 2.36). Nothing is loaded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace ddssec::governance::doctor {

/// Where the dynamic loader looks for a library that the host opens by its name alone.
struct LoaderPlaces {
  std::string library_path;                              ///< LD_LIBRARY_PATH
  std::filesystem::path cache = "/etc/ld.so.cache";      ///< what ldconfig wrote
  std::vector<std::filesystem::path> system = {};        ///< its own folders, in their order
  std::vector<std::filesystem::path> after_loader = {};  ///< where the host looks by itself then
  std::filesystem::path dropin = {};  ///< of this program's installation or build; empty: none
  /// Subfolders of every folder that come before the folder itself, in the loader's order, such as
  /// "glibc-hwcaps/x86-64-v3" (loader_subfolders.hpp).
  std::vector<std::string> subfolders = {};

  /// Of this process: its variable, and the folders of this machine.
  static LoaderPlaces here();
};

/// What the loader makes of a file.
enum class LibraryState : std::uint8_t {
  absent,    ///< not there, not readable, or for another class of machine: the search goes on
  loadable,  ///< as far as its header shows
  refused,   ///< no library of this machine, as a folder or an empty file: the search ends
  cut_off,   ///< shorter than its header says: the process that loads it ends by SIGBUS
};
LibraryState library_state(const std::filesystem::path& file);

/// The file that the loader comes to, and what it makes of it; `absent` has no file.
struct FoundLibrary {
  std::filesystem::path file = {};
  LibraryState state = LibraryState::absent;
};
FoundLibrary found_by_loader(const std::string& name, const LoaderPlaces& places);
/// The first in these folders and their subfolders.
FoundLibrary found_in(const std::vector<std::filesystem::path>& folders,
                      const std::vector<std::string>& subfolders, const std::string& name);

/// The folders of LD_LIBRARY_PATH or of a DT_RUNPATH; an empty one is ".".
std::vector<std::filesystem::path> folders_of(std::string_view library_path);

/// At most 64 MiB of a file.
std::string library_octets(const std::filesystem::path& path);

}  // namespace ddssec::governance::doctor
