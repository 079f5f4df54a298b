// Where the plugins' events go inside a Cyclone DDS process: Cyclone's log, and a file of JSON
// lines.
#pragma once

#include <cstdint>
#include <memory>

#include "base/event.hpp"

namespace ddssec::cyclonedds {

/// Cyclone's dds_log: category, file, line, function, format, arguments.
using LogFunction = void (*)(std::uint32_t, const char*, std::uint32_t, const char*, const char*,
                             ...);

/// The dds_log of the library or program that `caller` (an address in its code) belongs to, else
/// any that the process sees, else nullptr. Nothing of Cyclone is linked: one plugin serves all
/// its versions.
LogFunction find_host_log(const void* caller) noexcept;

/// Cyclone's log category of a severity; 0 = not worth a line there.
std::uint32_t log_category(Severity severity);
/// The same of an event. Cyclone DDS shows no informational lines unless asked to; logged as
/// warnings, since they must be seen without asking: which plugins are in use, that there is no
/// revocation list, and that a newer one is in force.
std::uint32_t log_category(const Event& event);

/// One line an event to `log` (stderr when null), and one JSON object a line appended to
/// the file `json_path` unless that is null or empty.
std::unique_ptr<EventSink> make_host_log(LogFunction log, const char* json_path);

/// The same with the host's own log and the file that DDSSEC_EVENT_LOG names.
std::unique_ptr<EventSink> make_host_log_for(const void* caller);

}  // namespace ddssec::cyclonedds
