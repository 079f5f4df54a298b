// Validation of a document against the OMG's schema by xmllint.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include "tests/support/test_data.hpp"
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {

/// Validates with xmllint against the standard's schema, "governance.xsd" or "permissions.xsd".
inline ::testing::AssertionResult is_valid(const std::string& xml, const std::string& schema) {
  const auto file = std::filesystem::temp_directory_path() /
                    ("ddssec_write_" + std::to_string(std::random_device()()) + ".xml");
  std::ofstream(file) << xml;
  const std::string command = std::string(DDSSEC_XMLLINT) + " --noout --nonet --schema " +
                              test::data_path("dds-security-xsd/" + schema) + " " + file.string() +
                              " 2>&1";
  const int status = std::system(command.c_str());
  std::filesystem::remove(file);
  if (status == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << xml;
}

}  // namespace ddssec::governance
