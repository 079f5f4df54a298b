#include "governance/doctor/host_plugins.hpp"

#include <algorithm>
#include <array>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/shell_word.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"
#include "governance/doctor/needed_libraries.hpp"

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;
using PluginProduct = HostPlugin::PluginProduct;

constexpr std::string_view kOurMark = "ddssec_";
constexpr std::string_view kVersionMark = "ddssec plugin version ";  // plugins/cyclonedds

struct Kind {
  std::string_view element;  // element of the configuration, in lower case
  std::string_view role;
  std::string_view library;  // name of the library unless the configuration names another
};
constexpr std::array kKinds{Kind{"authentication", "authentication", "dds_security_auth"},
                            Kind{"accesscontrol", "access control", "dds_security_ac"},
                            Kind{"cryptographic", "cryptography", "dds_security_crypto"}};

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool is_path(const std::string& library) { return library.contains('/'); }

struct Search {
  FoundLibrary found = {};
  fs::path obstacle = {};  // the file at which the loader's search ended without a library
};

// Searches as ddsrt_dlopen does. A path is used as it is. For a name lib*.so comes first, and
// Debian's Cyclone DDS then looks in a private folder. A name that the loader refuses counts as not
// found.
Search search_for(const std::string& library, const LoaderPlaces& places) {
  Search out;
  const auto is_settled = [&](FoundLibrary found) {
    if (found.state == LibraryState::refused && out.obstacle.empty()) out.obstacle = found.file;
    const bool loads =
        found.state == LibraryState::loadable || found.state == LibraryState::cut_off;
    if (loads) out.found = std::move(found);
    return loads;
  };
  if (is_path(library)) {
    constexpr std::string_view kScheme = "file://";
    const fs::path file(library.starts_with(kScheme) ? library.substr(kScheme.size()) : library);
    is_settled({file, library_state(file)});
    return out;
  }
  const auto name = "lib" + library + ".so";
  if (is_settled(found_by_loader(name, places))) return out;
  for (const auto& folder : places.after_loader)
    if (is_settled({folder / name, library_state(folder / name)})) return out;
  is_settled(found_by_loader(library, places));
  return out;
}

std::string version_in(std::string_view octets) {
  const auto at = octets.find(kVersionMark);
  if (at == octets.npos) return {};
  const auto rest = octets.substr(at + kVersionMark.size());
  return std::string(rest.substr(0, rest.find_first_not_of("0123456789.")));
}

// The libraries that the file needs and that the loader would not find. Libraries that those
// libraries need are not searched for, because their packages install them.
std::vector<std::string> missing_for(const fs::path& file, std::string_view octets,
                                     const LoaderPlaces& places) {
  const auto needed = needed_libraries(octets);
  auto own = folders_of(needed.search_path);
  for (auto& folder : own) {
    const auto text = folder.string();
    if (text.starts_with("$ORIGIN"))
      folder = file.parent_path().string() + text.substr(std::string_view("$ORIGIN").size());
  }
  std::vector<std::string> out;
  for (const auto& name : needed.names)
    if (!name.starts_with("ld-linux") &&
        found_in(own, places.subfolders, name).state == LibraryState::absent &&
        found_by_loader(name, places).state == LibraryState::absent)
      out.push_back(name);
  return out;
}

HostPlugin plugin_of(const Kind& kind, std::string library, const LoaderPlaces& places) {
  HostPlugin out{.role = kind.role, .library = std::move(library), .file = {}};
  auto search = search_for(out.library, places);
  out.file = std::move(search.found.file);
  out.obstacle = std::move(search.obstacle);
  if (out.file.empty()) return out;
  out.is_cut_off = search.found.state == LibraryState::cut_off;
  const auto octets = library_octets(out.file);
  out.product = octets.find(kOurMark) != octets.npos ? PluginProduct::ddssec : PluginProduct::other;
  if (out.product != PluginProduct::ddssec) return out;
  out.version = version_in(octets);
  out.missing = missing_for(out.file, octets, places);
  return out;
}

// The value of path="..." or path='...'; empty if the tag has none.
std::optional<std::string> path_attribute(std::string_view attributes) {
  const auto at = attributes.find("path");
  const auto begin = at == attributes.npos ? at : attributes.find_first_of("\"'", at);
  if (begin == attributes.npos) return std::nullopt;
  const auto end = attributes.find(attributes[begin], begin + 1);
  if (end == attributes.npos) return std::nullopt;
  return std::string(attributes.substr(begin + 1, end - begin - 1));
}

std::string listed(const std::vector<HostPlugin>& plugins) {
  std::string out;
  for (const auto& plugin : plugins)
    out += fmt::format("{}{}: {}{}", out.empty() ? "" : ", ", plugin.role, product_of(plugin),
                       plugin.file.empty() ? "" : fmt::format(" ({})", plugin.file.string()));
  return out;
}

bool is_named_like_ours(const fs::path& folder) {
  const auto text = folder.string();
  return text.contains("ddssec") || text.contains("dropin");
}

// The evidence that this folder was intended to provide ddssec's plugins to the host, although it
// does not; empty if there is none.
std::string sign_of_ours(const fs::path& folder, const std::vector<HostPlugin>& plugins) {
  std::error_code ignored;
  if (!fs::is_directory(folder, ignored))
    return is_named_like_ours(folder) ? folder.string() + " is no folder" : std::string();
  for (const auto& plugin : plugins) {
    const auto file = folder / ("lib" + plugin.library + ".so");
    if (file == plugin.obstacle)
      return fmt::format("{} is no library of this machine, and the loader looks no further",
                         file.string());
    if (fs::is_symlink(fs::symlink_status(file, ignored)) && !fs::exists(file, ignored))
      return file.string() + " is a link that leads nowhere";
    if (is_file(file) && is_ours(file))
      return fmt::format("{} is ddssec's, and {} comes before it", file.string(),
                         plugin.file.string());
  }
  if (is_file(folder / "libddssec_authentication.so"))
    return fmt::format("{} has ddssec's plugins under names that the configuration does not name",
                       folder.string());
  return {};
}

std::string hint_for(const LoaderPlaces& places) {
  const auto what = places.dropin.empty()
                        ? "let LD_LIBRARY_PATH begin with the folder that has ddssec's three "
                          "libdds_security_*.so (lib/ddssec/dropin of an installation, "
                          "build/release/dropin of a build)"
                        : library_path_line(places.dropin);
  return what + " where the application starts; the application's log then says plugins_in_use";
}

Finding finding_of(std::string message, const std::vector<HostPlugin>& plugins,
                   const LoaderPlaces& places) {
  return {.rule = Rule::DOC068,
          .message = std::move(message),
          .document = plugins.front().file,
          .hint = hint_for(places),
          .severity = Severity::warning};
}

Finding cut_off(const fs::path& file, const std::vector<HostPlugin>& plugins,
                const LoaderPlaces& places) {
  auto out =
      finding_of(fmt::format("{} is cut off: a Cyclone DDS process that loads it ends with a "
                             "bus error",
                             file.string()),
                 plugins, places);
  out.document = file;
  out.hint = "copy the file again, and compare its size; " + out.hint;
  return out;
}

// The host continues without these plugins and reports nothing. It does not replace plugins that
// are named by absolute paths.
Finding not_loadable(const std::vector<HostPlugin>& plugins) {
  std::set<std::string> missing;
  for (const auto& plugin : plugins) missing.insert(plugin.missing.begin(), plugin.missing.end());
  const auto& first = *std::ranges::find_if(
      plugins, [](const HostPlugin& plugin) { return !plugin.missing.empty(); });
  return {.rule = Rule::DOC068,
          .message = fmt::format(
              "ddssec's plugins in {} cannot be loaded: {} {} not on this machine; {}",
              first.file.parent_path().string(), fmt::join(missing, ", "),
              missing.size() == 1 ? "is" : "are",
              is_path(first.library)
                  ? "Cyclone DDS does not start"
                  : "Cyclone DDS would run its own plugins instead, if it finds them, and say "
                    "nothing"),
          .document = first.file,
          .hint =
              "install the packages that the drop-in needs "
              "(docs/secure-two-cyclone-applications.md, \"On two machines\"); "
              "ldd names each library",
          .severity = Severity::warning};
}

void diagnose_stock_plugins(const std::vector<HostPlugin>& plugins, const LoaderPlaces& places,
                            bool were_ours_meant, Diagnosis& out) {
  for (const auto& folder : folders_of(places.library_path))
    if (const auto sign = sign_of_ours(folder, plugins); !sign.empty())
      return out.report(
          {.ddssec = Outcome::fail},
          finding_of(fmt::format("Cyclone DDS would not load ddssec's plugins, although "
                                 "LD_LIBRARY_PATH seems to name them: {} ({})",
                                 sign, listed(plugins)),
                     plugins, places));
  if (!were_ours_meant || plugins.front().file.empty()) return;
  auto finding = finding_of(
      fmt::format("an application on Cyclone DDS that starts with this LD_LIBRARY_PATH runs the "
                  "stock plugins, not ddssec's: {}",
                  listed(plugins)),
      plugins, places);
  finding.products = {"ddssec"};
  finding.hint += "; nothing to do for the embedded participant, which loads no plugins";
  out.report({}, std::move(finding));
}

}  // namespace

std::string product_of(const HostPlugin& plugin) {
  if (plugin.product == PluginProduct::none) return "not found";
  if (plugin.product == PluginProduct::other) return "stock, not ddssec's";
  return plugin.version.empty() ? "ddssec" : "ddssec " + plugin.version;
}

std::vector<HostPlugin> host_plugins(std::string_view configuration, const LoaderPlaces& places) {
  const auto text = without_comments(configuration);
  std::vector<HostPlugin> out;
  for (const auto& kind : kKinds) {
    const auto section = find_tag(text, kind.element);
    if (!section) return {};
    const auto library = find_tag(section->after, "library");
    const auto path = library ? path_attribute(library->attributes) : std::nullopt;
    if (path && path->contains('$')) return {};
    out.push_back(plugin_of(kind, path.value_or(std::string(kind.library)), places));
  }
  return out;
}

std::vector<HostPlugin> plugins_of_node(const LoaderPlaces& places) {
  std::vector<HostPlugin> out;
  for (const auto& kind : kKinds) out.push_back(plugin_of(kind, std::string(kind.library), places));
  return out;
}

fs::path library_file(const std::string& library, const LoaderPlaces& places) {
  return search_for(library, places).found.file;
}

bool is_ours(const fs::path& library) {
  return library_octets(library).find(kOurMark) != std::string::npos;
}

void diagnose_host_plugins(const std::vector<HostPlugin>& plugins, const LoaderPlaces& places,
                           bool were_ours_meant, Diagnosis& out) {
  if (plugins.empty()) return;
  const auto is_missing_path = [](const HostPlugin& plugin) {
    return plugin.product == PluginProduct::none && is_path(plugin.library);
  };
  // DOC102 reports a missing library that is named by a path; LD_LIBRARY_PATH is not its cause.
  if (std::ranges::any_of(plugins, is_missing_path)) return;
  if (const auto one = std::ranges::find_if(plugins, &HostPlugin::is_cut_off); one != plugins.end())
    return out.report({.cyclonedds = Outcome::fail, .ddssec = Outcome::fail},
                      cut_off(one->file, plugins, places));
  std::set<PluginProduct> products;
  std::set<std::string> versions;
  for (const auto& plugin : plugins) {
    products.insert(plugin.product);
    if (plugin.product == PluginProduct::ddssec) versions.insert(plugin.version);
  }
  if (products.size() > 1 && products.contains(PluginProduct::none))
    return out.report(
        {.cyclonedds = Outcome::fail, .ddssec = Outcome::fail},
        finding_of("Cyclone DDS would not find all of its plugins: " + listed(plugins), plugins,
                   places));
  // Such plugins work together, but without the refusals and reports that only ddssec's provide.
  if (products.size() > 1 || versions.size() > 1)
    return out.report(
        {.ddssec = Outcome::unsafe},
        finding_of(fmt::format("Cyclone DDS would load plugins of two {}: {}",
                               products.size() > 1 ? "products" : "versions", listed(plugins)),
                   plugins, places));
  if (!products.contains(PluginProduct::ddssec))
    return diagnose_stock_plugins(plugins, places, were_ours_meant, out);
  out.pass(Rule::DOC068);
  diagnose_loadable(plugins, out);
}

void diagnose_loadable(const std::vector<HostPlugin>& plugins, Diagnosis& out) {
  const auto is_loadable = [](const HostPlugin& plugin) { return plugin.missing.empty(); };
  const auto first = std::ranges::find_if_not(plugins, is_loadable);
  if (first == plugins.end()) return;
  const auto stock = is_path(first->library) ? Outcome::fail : Outcome::ok;
  out.report({.cyclonedds = stock, .ddssec = Outcome::fail}, not_loadable(plugins));
}

}  // namespace ddssec::governance::doctor
