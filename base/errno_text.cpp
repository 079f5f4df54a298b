#include "base/errno_text.hpp"

#include <system_error>

namespace ddssec {

std::string errno_text(int error) { return std::generic_category().message(error); }

}  // namespace ddssec
