// The outputs for the plugins' events in a Cyclone DDS process: Cyclone's log, and a file of JSON
// lines.
#pragma once

#include <cstdint>
#include <memory>

#include "base/event.hpp"

namespace ddssec::cyclonedds {

/// Cyclone's dds_log: category, file, line, function, format, arguments.
using LogFunction = void (*)(std::uint32_t, const char*, std::uint32_t, const char*, const char*,
                             ...);

/// Returns the dds_log of the library or program that contains `caller` (an address in its code);
/// otherwise any in the process; otherwise nullptr. The plugin is not linked with Cyclone, so that
/// it works with all its versions.
LogFunction find_host_log(const void* caller) noexcept;

/// Returns Cyclone's log category for a severity; 0 if it is not logged there.
std::uint32_t log_category(Severity severity);
/// Returns the same for an event. Cyclone DDS shows no informational lines by default. So three of
/// them are logged as warnings: which plugins are in use, that there is no revocation list, and
/// that a newer one is in force.
std::uint32_t log_category(const Event& event);

/// Makes an output that writes one line per event to `log` (stderr if null), and appends one JSON
/// object per line to the file `json_path` unless that is null or empty.
std::unique_ptr<EventSink> make_host_log(LogFunction log, const char* json_path);

/// Makes the same output with the host's own log and the file that DDSSEC_EVENT_LOG names.
std::unique_ptr<EventSink> make_host_log_for(const void* caller);

}  // namespace ddssec::cyclonedds
