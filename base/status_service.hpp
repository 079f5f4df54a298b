// The record of a process's documents, and the socket that shows it, if the environment asks.
#pragma once

#include <memory>

#include "base/documents_in_use.hpp"
#include "base/event.hpp"

namespace ddssec {

/// The record that all participants of this library in this process share. It is shown by a socket
/// in the folder that the environment variable DDSSEC_STATUS_DIR names, as long as one caller keeps
/// the result. Null: the variable is not set or must not be trusted (secure_getenv), the socket
/// cannot be made, or this is the child of a fork() of a process that shows its own. Why a socket
/// cannot be made is raised once in a process, unless `events` is null: status_not_served.
std::shared_ptr<DocumentsInUse> documents_shown(EventSink* events);

}  // namespace ddssec
