// Checks whether the plugin libraries that Cyclone DDS would load can be loaded here.
#pragma once

#include <filesystem>
#include <string>

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// The result of loading one library.
struct PluginProbe {
  enum class Result : std::uint8_t {
    works,
    not_loadable,  ///< `detail` is the loader's reason
    lacks_entry,   ///< `detail` is the missing function's name
    died,          ///< loading it crashed the process
  };
  Result result = Result::not_loadable;
  std::string detail = {};
};

/// Loads `library` (a path, or a name for the loader to find) and searches for the functions
/// init_`role` and finalize_`role`. This happens in a child process with a limit of five seconds,
/// so a library that crashes or hangs does no harm. Loading a library runs its code.
PluginProbe probe_plugin(const std::string& library, const std::string& role);

/// Checks the three plugins in `folder` (for ddssec). If `folder` is empty, checks those that
/// Cyclone DDS finds by its default names (for cyclonedds; nothing is reported without Cyclone
/// DDS).
void diagnose_plugins(const std::filesystem::path& folder, Diagnosis& out);

}  // namespace ddssec::governance::doctor
