// The text of an error number of the operating system.
#pragma once

#include <string>

namespace ddssec {

/// Returns the system's text for a value of errno, such as "No such file or directory". Unlike
/// strerror() it may be called in any thread.
std::string errno_text(int error);

}  // namespace ddssec
