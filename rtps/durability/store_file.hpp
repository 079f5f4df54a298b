// The file of a sample store, before SQLite opens it.
#pragma once

#include <string>

#include "base/result.hpp"

namespace ddssec::rtps {

/// Creates the file, with mode 0600, or checks the existing one: it must be empty or a SQLite
/// database, and private to this process's user, as must be SQLite's files next to it. SQLite would
/// create a file that everyone can read, and accept one of a few octets as an empty database.
/// Errors: rtps_store_unusable.
Status make_store_file(const std::string& path);

}  // namespace ddssec::rtps
