#include "cli/documents/ros_policy.hpp"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "base/text.hpp"
#include "cli/inputs/files.hpp"
#include "governance/ros_node.hpp"
#include "governance/xml_check.hpp"

namespace ddssec::cli {

using governance::RosElement;
using governance::RosEnclave;
using governance::RosPolicy;

namespace {

namespace fs = std::filesystem;

std::string paths_of(const RosPolicy& policy) {
  constexpr std::size_t kMax = 256;
  std::string out;
  for (const auto& enclave : policy.enclaves) {
    if (out.size() > kMax) return out + ", ...";
    out += (out.empty() ? "" : ", ") + enclave.path;
  }
  return out;
}

bool has_dds_prefix(std::string_view name) {
  if (name.starts_with('/')) name.remove_prefix(1);
  return name.starts_with("rt/") || name.starts_with("rq/") || name.starts_with("rr/");
}

// A policy may come from another person, so an included file must not be a link to any other file
// of this machine.
Status check_inside(const fs::path& included, const fs::path& policy) {
  std::error_code ignored;
  const auto root =
      fs::weakly_canonical(policy.has_parent_path() ? policy.parent_path() : ".", ignored);
  const auto real = fs::weakly_canonical(included, ignored);
  const auto below = real.lexically_relative(root);
  if (!below.empty() && *below.begin() != "..") return {};
  return fail(Code::policy_include, {.document = policy,
                                     .expected = "a file beside or below the policy",
                                     .found = included.string() + ", a link to " + real.string()});
}

}  // namespace

Result<RosPolicy> read_policy(const std::filesystem::path& file,
                              const std::vector<std::string>& wanted) {
  const auto read = [&](const fs::path& path) -> Result<Bytes> {
    if (path != file) DDSSEC_RETURN_IF_ERROR(check_inside(path, file));
    return read_file(path, governance::kMaxXmlOctets);
  };
  DDSSEC_ASSIGN_OR_RETURN(auto policy, governance::read_ros_policy(file, read));
  if (wanted.empty()) return policy;
  for (const auto& path : wanted)
    if (std::ranges::find(policy.enclaves, path, &RosEnclave::path) == policy.enclaves.end())
      return fail(Code::usage, {.document = file,
                                .expected = "an enclave of the policy: " + paths_of(policy),
                                .found = '"' + path + '"'});
  std::erase_if(policy.enclaves, [&](const RosEnclave& enclave) {
    return std::ranges::find(wanted, enclave.path) == wanted.end();
  });
  return policy;
}

RosPolicy with_options(RosPolicy policy, const Arguments& arguments) {
  return arguments.has("--node-defaults") ? with_node_defaults(std::move(policy)) : policy;
}

std::vector<Finding> merged_profiles(const RosPolicy& policy) {
  std::map<std::string, std::size_t> lists;
  for (const auto& enclave : policy.enclaves) lists[enclave.path] += enclave.profiles.size();
  std::vector<Finding> out;
  for (const auto& [path, count] : lists) {
    if (count < 2) continue;
    const auto enclave = std::ranges::find(policy.enclaves, path, &RosEnclave::path);
    out.push_back({.rule = Rule::PERM031,
                   .message = fmt::format("enclave {}: {} <profiles> elements are one grant now",
                                          path, count),
                   .line = enclave->line});
  }
  return out;
}

std::vector<Finding> prefixed_names(const RosPolicy& policy) {
  constexpr std::size_t kMax = 16;  // more findings would report nothing new
  std::vector<Finding> out;
  const auto look_at = [&](const RosEnclave& enclave, const RosElement& element) {
    for (const auto& written : element.names)
      if (out.size() < kMax && has_dds_prefix(trimmed(written)))
        out.push_back({.rule = Rule::PERM035,
                       .message = fmt::format("enclave {}: \"{}\" begins like a name of DDS; the "
                                              "permissions get a further prefix in front of it",
                                              enclave.path, trimmed(written)),
                       .line = enclave.line});
  };
  for (const auto& enclave : policy.enclaves)
    for (const auto& profiles : enclave.profiles)
      for (const auto& profile : profiles)
        for (const auto& element : profile.elements) look_at(enclave, element);
  return out;
}

}  // namespace ddssec::cli
