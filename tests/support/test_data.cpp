#include "tests/support/test_data.hpp"

namespace ddssec::test {

std::string data_path(std::string_view name) {
  return std::string(DDSSEC_TEST_DATA "/").append(name);
}

}  // namespace ddssec::test
