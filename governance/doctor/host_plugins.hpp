// Determines which plugin libraries Cyclone DDS would load in an environment: ddssec's or others.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/library_search.hpp"

namespace ddssec::governance::doctor {

/// One plugin of the configuration, and the library that the loader would find for it.
struct HostPlugin {
  enum class PluginProduct : std::uint8_t { none, ddssec, other };
  std::string_view role;       ///< authentication, access control, cryptography
  std::string library;         ///< the `path` of its <Library>
  std::filesystem::path file;  ///< empty if it was not found
  PluginProduct product = PluginProduct::none;
  std::string version = {};  ///< the version of a ddssec library; empty if unknown
  /// Libraries that a ddssec library needs and the loader would not find.
  std::vector<std::string> missing = {};
  bool is_cut_off = false;  ///< the process that loads it crashes
  /// A file that is no library, at which the search of the loader ended.
  std::filesystem::path obstacle = {};
};
/// Returns "ddssec 0.2.0", "stock, not ddssec's" or "not found".
std::string product_of(const HostPlugin& plugin);

/// Returns the three plugins of a configuration; empty if it does not configure security, or names
/// a library with a variable in it. Nothing is loaded.
std::vector<HostPlugin> host_plugins(std::string_view configuration, const LoaderPlaces& places);
/// Returns the plugins that rmw_cyclonedds_cpp configures.
std::vector<HostPlugin> plugins_of_node(const LoaderPlaces& places);

/// Returns the file that Cyclone DDS would load for a library's name or path; empty if it finds
/// none.
std::filesystem::path library_file(const std::string& library, const LoaderPlaces& places);

/// True if the file is a ddssec library, judged by its content. It is not loaded, because that
/// would run its code.
bool is_ours(const std::filesystem::path& library);

/// Reports plugins that are missing, of several products or versions, or cannot be loaded. Also
/// reports other plugins if LD_LIBRARY_PATH or `were_ours_meant` shows that ddssec's were intended:
/// the application then runs without any message.
void diagnose_host_plugins(const std::vector<HostPlugin>& plugins, const LoaderPlaces& places,
                           bool were_ours_meant, Diagnosis& out);
/// Reports only ddssec plugins that cannot be loaded here.
void diagnose_loadable(const std::vector<HostPlugin>& plugins, Diagnosis& out);

}  // namespace ddssec::governance::doctor
