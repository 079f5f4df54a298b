// The record of a process's documents, and the socket that shows it, if the environment asks.
#pragma once

#include <memory>

#include "base/documents_in_use.hpp"
#include "base/event.hpp"

namespace ddssec {

/// Returns the record that all participants of this library in this process share. A socket in the
/// folder that the environment variable DDSSEC_STATUS_DIR names shows it, as long as one caller
/// keeps the result. Returns null if the variable is not set or must not be trusted
/// (secure_getenv), if the socket cannot be made, or in the child of a fork() of a process that
/// shows its own record. If the socket cannot be made, status_not_served is raised once in a
/// process, unless `events` is null.
std::shared_ptr<DocumentsInUse> shared_status_record(EventSink* events);

}  // namespace ddssec
