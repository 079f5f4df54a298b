// Which plugin libraries Cyclone DDS would load in an environment: ddssec's, or others in their
// place.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "governance/doctor/diagnosis.hpp"
#include "governance/doctor/library_search.hpp"

namespace ddssec::governance::doctor {

/// One plugin as the configuration names it, and what the loader makes of that.
struct HostPlugin {
  enum class Maker : std::uint8_t { none, ours, other };
  std::string_view role;       ///< authentication, access control, cryptography
  std::string library;         ///< the `path` of its <Library>
  std::filesystem::path file;  ///< empty: nothing is found
  Maker maker = Maker::none;
  std::string version = {};  ///< of ours; empty: not known
  std::vector<std::string> missing =
      {};                               ///< libraries that ours needs and the loader would not find
  bool is_cut_off = false;              ///< the process that loads it ends
  std::filesystem::path obstacle = {};  ///< no library: here the loader's search ended before
};
/// "ddssec 0.2.0", "stock, not ddssec's", "not found".
std::string maker_of(const HostPlugin& plugin);

/// The three plugins of a configuration; none if it does not configure security, or names a library
/// with a variable in it. Nothing is loaded.
std::vector<HostPlugin> host_plugins(std::string_view configuration, const LoaderPlaces& places);
/// Those that rmw_cyclonedds_cpp configures.
std::vector<HostPlugin> plugins_of_node(const LoaderPlaces& places);

/// The file that Cyclone DDS would load for a library's name or path; empty: it finds none.
std::filesystem::path library_file(const std::string& library, const LoaderPlaces& places);

/// True if the file says that it is of ddssec. Not by loading it: that would run its code.
bool is_ours(const std::filesystem::path& library);

/// Reports plugins that are missing, of several products or versions, or not to be loaded, and
/// others in place of ours where LD_LIBRARY_PATH or `were_ours_meant` says that ours were meant:
/// the application runs nevertheless, and says nothing.
void check_host_plugins(const std::vector<HostPlugin>& plugins, const LoaderPlaces& places,
                        bool were_ours_meant, Diagnosis& out);
/// Reports plugins of ours that cannot be loaded here, and nothing else.
void check_loadable(const std::vector<HostPlugin>& plugins, Diagnosis& out);

}  // namespace ddssec::governance::doctor
