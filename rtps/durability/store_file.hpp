// The file of a sample store, before SQLite opens it.
#pragma once

#include <string>

#include "base/result.hpp"

namespace ddssec::rtps {

/// Creates the file, with mode 0600, or checks the existing one: it must be empty or a SQLite
/// database, and private to this process's user, as must be SQLite's files next to it. SQLite would
/// create a file that everyone can read, and accept one of a few octets as an empty database. Only
/// root and this user may be able to write to its folder and to those above (in one above, the
/// sticky bit suffices): another user could put a file in the place of one that was checked.
/// Returns the path without links. Errors: rtps_store_unusable.
Result<std::string> make_store_file(const std::string& given);

}  // namespace ddssec::rtps
