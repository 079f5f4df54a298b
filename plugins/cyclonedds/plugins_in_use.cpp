#include "plugins/cyclonedds/plugins_in_use.hpp"

#include <atomic>
#include <dlfcn.h>
#include <string_view>
#include <vector>

#include "base/openssl_flaws.hpp"
#include "plugins/cyclonedds/abi.hpp"

namespace ddssec::cyclonedds {
namespace {

struct Library {
  std::string_view name;
  const char* version_symbol;
};
constexpr std::array<Library, 3> kLibraries = {{
    {"authentication", "ddssec_authentication_version"},
    {"access control", "ddssec_access_control_version"},
    {"cryptography", "ddssec_cryptography_version"},
}};

// The library file contains its version, so that `ddssec doctor` can read it without loading the
// library.
constexpr std::string_view kVersionName = "ddssec plugin version ";
constexpr char kVersionMark[] = "ddssec plugin version " DDSSEC_VERSION;

// Returns the version of the ddssec library of that kind; nullptr if it is not loaded, for example
// because a stock one is used.
const char* version_of(std::size_t kind) noexcept {
  void* const symbol = dlsym(RTLD_DEFAULT, kLibraries[kind].version_symbol);
  return symbol == nullptr ? nullptr : reinterpret_cast<PluginVersion*>(symbol)();
}

// Returns "a", "a and b" or "a, b and c".
std::string listed(const std::vector<std::string_view>& names) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (i > 0) list += i + 1 == names.size() ? " and " : ", ";
    list += names[i];
  }
  return list;
}

// Returns the names of the plugins from ddssec, or of the others.
std::vector<std::string_view> named(const PluginVersions& found, bool are_ours) {
  std::vector<std::string_view> names;
  for (std::size_t i = 0; i < found.size(); ++i)
    if ((found[i] != nullptr) == are_ours) names.push_back(kLibraries[i].name);
  return names;
}

}  // namespace

const char* version() noexcept { return kVersionMark + kVersionName.size(); }

bool reports_for_all(PluginKind own) noexcept {
  for (std::size_t kind = 0; kind < static_cast<std::size_t>(own); ++kind)
    if (version_of(kind) != nullptr) return false;
  return true;
}

Event plugins_in_use(const PluginVersions& found, const std::string& openssl) {
  std::string differing;
  for (std::size_t i = 0; i < found.size(); ++i) {
    if (found[i] != nullptr && std::string_view(found[i]) != version())
      differing += ", but " + std::string(kLibraries[i].name) + " of " + found[i];
  }
  std::string note = listed(named(found, true)) + " of ddssec " + version() + differing;
  if (const auto others = named(found, false); !others.empty())
    note += ", " + listed(others) + " of another product";
  return Event(Error(Code::plugins_in_use, {.note = note + "; running on " + openssl}));
}

std::optional<Event> mixture_warning(const PluginVersions& found) {
  const auto others = named(found, false);
  if (others.empty()) return std::nullopt;
  return Event(Error(Code::plugins_mixed, {.expected = "all three plugins of ddssec",
                                           .found = listed(others) + " of another product"}));
}

std::optional<Event> openssl_warning(const std::string& openssl) {
  const auto advice = check_openssl_flaws(openssl);
  return advice ? std::nullopt : std::optional(Event(advice.error()));
}

std::optional<Event> transport_warning(std::optional<bool> has_udp) {
  if (has_udp.value_or(true)) return std::nullopt;
  return Event(Error(Code::transport_without_resets));
}

void report_clock_steps(Host& host, PluginKind own) noexcept {
  const auto report = host.calendar().take_report();
  if (report && reports_for_all(own)) host.notice(Event(*report));
}

void report_plugins_in_use(Host& host, PluginKind own, std::string (*openssl)()) noexcept {
  static std::atomic_flag said;
  if (said.test() || !reports_for_all(own) || said.test_and_set()) return;
  try {
    PluginVersions found = {version_of(0), version_of(1), version_of(2)};
    // This also works if the symbols of this library are not global.
    found[static_cast<std::size_t>(own)] = version();
    const auto version_text = openssl();
    host.notice(plugins_in_use(found, version_text));
    if (const auto warning = mixture_warning(found)) host.notice(*warning);
    if (const auto warning = openssl_warning(version_text)) host.notice(*warning);
  } catch (...) {
    // The plugins work even if there is no memory for the message.
  }
}

}  // namespace ddssec::cyclonedds
