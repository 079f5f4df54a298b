// Predicts which file the dynamic loader opens for a library name, as glibc's ld.so does (measured
// with 2.36). Nothing is loaded.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace ddssec::governance::doctor {

/// The places where the dynamic loader searches for a library that the host opens by name.
struct LoaderPlaces {
  std::string library_path;                          ///< LD_LIBRARY_PATH
  std::filesystem::path cache = "/etc/ld.so.cache";  ///< the cache of ldconfig
  std::vector<std::filesystem::path> system = {};    ///< the loader's own folders, in order
  /// The folders where the host searches afterwards.
  std::vector<std::filesystem::path> after_loader = {};
  /// The folder of this program's installation or build; empty if there is none.
  std::filesystem::path dropin = {};
  /// Subfolders that are searched before each folder itself, in the loader's order, such as
  /// "glibc-hwcaps/x86-64-v3" (loader_subfolders.hpp).
  std::vector<std::string> subfolders = {};

  /// Returns the places for this process: its variable, and the folders of this machine.
  static LoaderPlaces here();
};

/// Returns the folder with the drop-in of this program's installation or build; empty if there is
/// none.
std::filesystem::path own_dropin();

/// Returns the shell command after which a process finds ddssec's plugins in this folder first.
std::string library_path_line(const std::filesystem::path& dropin);

/// The loader's reaction to a file.
enum class LibraryState : std::uint8_t {
  absent,    ///< not there, not readable, or for another class of machine: the search goes on
  loadable,  ///< as far as its header shows
  refused,   ///< not a library for this machine, such as a folder or an empty file: the search ends
  cut_off,   ///< shorter than its header says: loading it crashes the process (SIGBUS)
};
LibraryState library_state(const std::filesystem::path& file);

/// The file that the loader finds, and its state. The state `absent` has no file.
struct FoundLibrary {
  std::filesystem::path file = {};
  LibraryState state = LibraryState::absent;
};
FoundLibrary found_by_loader(const std::string& name, const LoaderPlaces& places);
/// Returns the first library of the name in these folders and their subfolders.
FoundLibrary found_in(const std::vector<std::filesystem::path>& folders,
                      const std::vector<std::string>& subfolders, const std::string& name);

/// Returns the folders of LD_LIBRARY_PATH or of a DT_RUNPATH; an empty one is ".".
std::vector<std::filesystem::path> folders_of(std::string_view library_path);

/// Reads the first 64 MiB of a file at most.
std::string library_octets(const std::filesystem::path& path);

}  // namespace ddssec::governance::doctor
