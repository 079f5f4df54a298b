// Policies of sros2 in memory.
#pragma once

#include <map>
#include <string>

#include <fmt/format.h>

#include "governance/ros_policy.hpp"
#include "tests/unit/governance/governance_fixture.hpp"

namespace ddssec::governance {

/// Makes a policy from files in memory. The first one is read.
inline Result<RosPolicy> policy_from(const std::map<std::string, std::string>& files,
                                     const std::string& first = "policy.xml") {
  return read_ros_policy(first, [&](const std::filesystem::path& path) -> Result<Bytes> {
    const auto found = files.find(path.string());
    if (found == files.end()) return fail(Code::file_not_found, {.document = path});
    return to_bytes(as_bytes(found->second));
  });
}

/// Returns a policy of one enclave with this text inside its <profile>.
inline std::string profile(std::string_view inside, std::string_view ns = "/n") {
  return fmt::format(
      "<policy version=\"0.2.0\" xmlns:xi=\"http://www.w3.org/2001/XInclude\"><enclaves>"
      "<enclave path=\"/e\"><profiles><profile ns=\"{}\" node=\"m\">{}</profile></profiles>"
      "</enclave></enclaves></policy>",
      ns, inside);
}

}  // namespace ddssec::governance
