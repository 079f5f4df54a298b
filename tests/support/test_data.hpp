// The place of the files in tests/data.
#pragma once

#include <string>
#include <string_view>

namespace ddssec::test {

/// Returns the path of `name` below tests/data, on the machine that built the tests.
std::string data_path(std::string_view name);

}  // namespace ddssec::test
