#include "cli/participant/drop_in.hpp"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "governance/doctor/host_plugins.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr auto kWhere =
    "name the folder that has ddssec's three libdds_security_*.so: lib/ddssec/dropin of an "
    "installation, build/release/dropin of a build";

std::unexpected<Error> unusable_folder_error(const fs::path& folder, std::string note,
                                             std::string hint) {
  return fail(Code::usage, {.field = "--dropin",
                            .found = folder.string(),
                            .note = std::move(note),
                            .hint = std::move(hint)});
}

// True if Cyclone DDS reads the path as it is: it replaces variables in a configuration, and its
// attributes are XML.
bool is_plain(const std::string& path) {
  return std::ranges::none_of(path, [](const char c) {
    return std::string_view("$\\\"&<>`").contains(c) || static_cast<unsigned char>(c) < 0x20;
  });
}

Status check_libraries(const fs::path& folder) {
  for (const auto* name : {"auth", "ac", "crypto"}) {
    const auto file = folder / fmt::format("libdds_security_{}.so", name);
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored))
      return unusable_folder_error(folder, "it has no " + file.filename().string(), kWhere);
    if (!governance::doctor::is_ours(file))
      return unusable_folder_error(folder, "its " + file.filename().string() + " is not ddssec's",
                                   kWhere);
  }
  return {};
}

}  // namespace

Result<fs::path> drop_in_of(const Arguments& arguments) {
  if (!arguments.has("--dropin")) return fs::path();
  const fs::path given = arguments.text("--dropin");
  std::error_code error;
  const auto whole = fs::absolute(given, error).lexically_normal();
  if (given.empty() || error || !is_plain(whole.string()))
    return unusable_folder_error(given, "a configuration cannot name it",
                                 "choose a folder without $, \\, \", &, <, > and ` in its path");
  if (fs::exists(whole, error)) {
    DDSSEC_RETURN_IF_ERROR(check_libraries(whole));
  } else if (given.is_relative()) {
    return unusable_folder_error(given, "there is no such folder here",
                                 "name a folder of another machine by its whole path");
  }
  return whole;
}

std::string drop_in_line(const fs::path& dropin) {
  if (dropin.empty())
    return "cyclonedds.xml does not say where ddssec's plugins are: Cyclone DDS loads them if "
           "LD_LIBRARY_PATH has their folder, and its own plugins if not. --dropin FOLDER names "
           "the folder in it\n";
  std::error_code ignored;
  return fmt::format(
      "cyclonedds.xml names ddssec's libraries in {}{}: LD_LIBRARY_PATH is not needed, and without "
      "them there Cyclone DDS does not start\n",
      dropin.string(), fs::exists(dropin, ignored) ? "" : ", which is not on this machine");
}

}  // namespace ddssec::cli
