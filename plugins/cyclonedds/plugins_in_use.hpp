// The event that reports which plugins a process uses.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "base/openssl_version.hpp"
#include "plugins/cyclonedds/host.hpp"

namespace ddssec::cyclonedds {

/// The plugins, in the order in which Cyclone DDS loads them.
enum class PluginKind { authentication, access_control, cryptography };

/// Returns the project's version, which each library exports as a symbol.
const char* version() noexcept;

/// True if no other ddssec library in this process comes before this one. That library reports on
/// behalf of all three, so that events about the process are raised once. It is evaluated late,
/// because the host loads the libraries one after the other.
bool reports_for_all(PluginKind own) noexcept;

/// Raises plugins_in_use once per process: which of the three plugins are from ddssec, their
/// version, and their version of OpenSSL. Then plugins_mixed if not all are from ddssec, and
/// openssl_known_unsafe if that version has known flaws. Call it when a participant is created: by
/// then all plugins are loaded.
void report_plugins_in_use(Host& host, PluginKind own,
                           std::string (*openssl)() = openssl_version) noexcept;

/// Returns the event transport_without_resets if the process has no UDP socket; otherwise empty.
/// `has_udp` is empty if that is not known.
std::optional<Event> transport_warning(std::optional<bool> has_udp);

/// Raises an event if the calendar was set, and about the outcome. Only the library that reports
/// for all does so.
void report_clock_steps(Host& host, PluginKind own) noexcept;

/// The version of the ddssec plugin of each kind; nullptr if a stock plugin or another vendor's is
/// loaded.
using PluginVersions = std::array<const char*, 3>;
/// Returns the event plugins_in_use. `openssl` is the result of openssl_version().
Event plugins_in_use(const PluginVersions& found, const std::string& openssl);
/// Returns the event plugins_mixed; empty if all three plugins are from ddssec.
std::optional<Event> mixture_warning(const PluginVersions& found);
/// Returns the event openssl_known_unsafe; empty if no flaw is certain.
std::optional<Event> openssl_warning(const std::string& openssl);

}  // namespace ddssec::cyclonedds
