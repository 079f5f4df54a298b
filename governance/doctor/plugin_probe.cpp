#include "governance/doctor/plugin_probe.hpp"

#include <array>
#include <csignal>
#include <dlfcn.h>
#include <link.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

namespace ddssec::governance::doctor {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxMilliseconds = 5000;
constexpr std::size_t kMaxDetail = 1024;

// Returns the output of a child process that calls `work`. Its first octet is the result.
std::string ask_child(void (*work)(int, const std::string&, const std::string&),
                      const std::string& first, const std::string& second) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0) return {};
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    work(ends[1], first, second);
    ::_exit(0);  // runs no destructors of what was loaded
  }
  ::close(ends[1]);
  std::string out;
  pollfd readable{.fd = ends[0], .events = POLLIN, .revents = 0};
  std::array<char, kMaxDetail> block{};
  if (child > 0 && ::poll(&readable, 1, kMaxMilliseconds) == 1) {
    const auto size = ::read(ends[0], block.data(), block.size());
    if (size > 0) out.assign(block.data(), static_cast<std::size_t>(size));
  }
  ::close(ends[0]);
  if (child > 0) {
    ::kill(child, SIGKILL);  // the child has written its result, or hangs
    ::waitpid(child, nullptr, 0);
  }
  return out;
}

void say(int to, char result, std::string_view detail) {
  const auto text = fmt::format("{}{}", result, detail.substr(0, kMaxDetail - 1));
  // A failed write cannot be reported; the parent treats missing output as failure.
  [[maybe_unused]] const auto written = ::write(to, text.data(), text.size());
}

void load(int to, const std::string& library, const std::string& role) {
  void* handle = ::dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (handle == nullptr) {
    const char* reason = ::dlerror();
    return say(to, 'n', reason != nullptr ? reason : "");
  }
  for (const auto* verb : {"init_", "finalize_"})
    if (::dlsym(handle, (verb + role).c_str()) == nullptr) return say(to, 'e', verb + role);
  say(to, 'w', "");
}

// Writes the folder of Cyclone DDS's own library, if there is one.
void find_host(int to, const std::string&, const std::string&) {
  for (const auto* name : {"libddsc.so.0debian", "libddsc.so.0", "libddsc.so"}) {
    void* handle = ::dlopen(name, RTLD_LAZY | RTLD_LOCAL);
    const link_map* map = nullptr;
    if (handle == nullptr || ::dlinfo(handle, RTLD_DI_LINKMAP, &map) != 0) continue;
    return say(to, 'w', fs::path(map->l_name).parent_path().string());
  }
}

struct Plugin {
  std::string_view library;
  std::string_view role;
};
// These names are fixed in rmw_cyclonedds_cpp.
constexpr std::array kPlugins{Plugin{"libdds_security_auth.so", "authentication"},
                              Plugin{"libdds_security_ac.so", "access_control"},
                              Plugin{"libdds_security_crypto.so", "crypto"}};

void report(const Plugin& plugin, const PluginProbe& probe, const std::string& tried, bool ours,
            Diagnosis& out) {
  const auto about = ours ? "ddssec" : "Cyclone DDS";
  const auto outcomes =
      ours ? Outcomes{.ddssec = Outcome::fail} : Outcomes{.cyclonedds = Outcome::fail};
  const bool entry = probe.result == PluginProbe::Result::lacks_entry;
  const auto why = probe.result == PluginProbe::Result::died ? "loading it ends the process"
                   : entry ? fmt::format("it has no function {}", probe.detail)
                           : probe.detail;
  out.report(outcomes,
             {.rule = entry ? Rule::DOC071 : Rule::DOC070,
              .message = fmt::format("{} ({}): {}", plugin.library, plugin.role, why),
              .document = tried},
             about);
}

// Cyclone DDS asks the loader first. Debian's Cyclone DDS then looks in a private folder.
PluginProbe probe_default(const Plugin& plugin, const fs::path& host, std::string& tried) {
  const std::string role(plugin.role);
  tried = plugin.library;
  auto probe = probe_plugin(tried, role);
  if (probe.result != PluginProbe::Result::not_loadable) return probe;
  const auto own = (host / "libddsc0debian" / plugin.library).string();
  auto second = probe_plugin(own, role);
  std::error_code ignored;
  if (second.result == PluginProbe::Result::not_loadable && !fs::exists(own, ignored)) return probe;
  tried = own;
  return second;
}

}  // namespace

PluginProbe probe_plugin(const std::string& library, const std::string& role) {
  const auto said = ask_child(&load, library, role);
  if (said.empty()) return {PluginProbe::Result::died};
  const auto result = said[0] == 'w'   ? PluginProbe::Result::works
                      : said[0] == 'e' ? PluginProbe::Result::lacks_entry
                                       : PluginProbe::Result::not_loadable;
  return {result, said.substr(1)};
}

void diagnose_plugins(const fs::path& folder, Diagnosis& out) {
  const bool ours = !folder.empty();
  std::string host;
  if (!ours) host = ask_child(&find_host, "", "");
  if (!ours && host.empty()) return;
  const auto about = ours ? "ddssec" : "Cyclone DDS";
  out.pass(Rule::DOC070, about);
  out.pass(Rule::DOC071, about);
  std::error_code ignored;
  if (ours && !fs::is_directory(folder, ignored)) {
    out.report({.ddssec = Outcome::fail},
               {.rule = Rule::DOC070,
                .message = "the folder of the plugin libraries does not exist",
                .document = folder},
               about);
    return;
  }
  for (const auto& plugin : kPlugins) {
    std::string tried = (folder / plugin.library).string();
    const auto probe = ours ? probe_plugin(fs::absolute(tried).string(), std::string(plugin.role))
                            : probe_default(plugin, fs::path(host.substr(1)), tried);
    if (probe.result != PluginProbe::Result::works) report(plugin, probe, tried, ours, out);
  }
}

}  // namespace ddssec::governance::doctor
