// Whether the plugin libraries that Cyclone DDS would load can be loaded here.
#pragma once

#include <filesystem>
#include <string>

#include "governance/doctor/diagnosis.hpp"

namespace ddssec::governance::doctor {

/// What came of loading one library.
struct PluginProbe {
  enum class Result : std::uint8_t {
    works,
    not_loadable,  ///< `detail` is the loader's reason
    lacks_entry,   ///< `detail` is the missing function's name
    died,          ///< loading it ended the process
  };
  Result result = Result::not_loadable;
  std::string detail = {};
};

/// Loads `library` (a path, or a name for the loader to find) and looks for the functions
/// init_`role` and finalize_`role`. All of it happens in a child process, which gets five seconds:
/// a library that crashes or hangs does no harm here. Loading a library runs its code.
PluginProbe probe_plugin(const std::string& library, const std::string& role);

/// Looks at the three plugins in `folder` (for ours), or, if it is empty, where Cyclone DDS finds
/// them by its default names (for cyclonedds; nothing is reported if there is no Cyclone DDS).
void check_plugins(const std::filesystem::path& folder, Diagnosis& out);

}  // namespace ddssec::governance::doctor
