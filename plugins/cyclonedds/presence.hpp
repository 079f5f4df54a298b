// The line that says whose plugins a process uses.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "base/openssl_version.hpp"
#include "plugins/cyclonedds/host.hpp"

namespace ddssec::cyclonedds {

/// In the order in which Cyclone DDS loads them.
enum class PluginKind { authentication, access_control, cryptography };

/// The project's version, which each library shows under a symbol of its own.
const char* version() noexcept;

/// True if no library of ours in this process comes before this one: it speaks for all three, so
/// that what concerns the process is said once. Looked up late: the host loads the libraries one
/// after the other.
bool speaks_for_all(PluginKind own) noexcept;

/// plugins_in_use, once a process: which of the three plugins are ours, their version, and the
/// version of OpenSSL that they run on; then plugins_mixed if not all are ours, and
/// openssl_known_unsafe if that version has known flaws.
/// Call it when a participant is made: by then all are loaded.
void say_plugins_in_use(Host& host, PluginKind own,
                        std::string (*openssl)() = openssl_version) noexcept;

/// transport_without_resets if the process has no UDP socket, or nothing. `has_udp`: as far as that
/// is known.
std::optional<Event> transport_warning(std::optional<bool> has_udp);

/// Reports that the calendar was set, and what came of it; the library that speaks for all does.
void say_clock_steps(Host& host, PluginKind own) noexcept;

/// Of each kind the version of our plugin; null: a stock one, or another's, is in its place.
using PluginVersions = std::array<const char*, 3>;
/// The event itself. `openssl`: what openssl_version() says.
Event plugins_in_use(const PluginVersions& found, const std::string& openssl);
/// plugins_mixed, or nothing if all three are ours.
std::optional<Event> mixture_warning(const PluginVersions& found);
/// openssl_known_unsafe, or nothing.
std::optional<Event> openssl_warning(const std::string& openssl);

}  // namespace ddssec::cyclonedds
