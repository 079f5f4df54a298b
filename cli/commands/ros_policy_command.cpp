// permissions from-ros-policy: converts sros2's policy files to DDS permissions.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "cli/ca/new_document.hpp"
#include "cli/commands/groups.hpp"
#include "cli/documents/documents.hpp"
#include "cli/documents/ros_policy.hpp"
#include "cli/frame/options.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/times.hpp"
#include "governance/lint.hpp"
#include "governance/write.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;
// As long as the certificate, as sros2 does, if --validity-from names one; otherwise --days from
// now.
Result<governance::Validity> life(const Arguments& arguments, WallTime now) {
  if (arguments.has("--validity-from")) {
    DDSSEC_ASSIGN_OR_RETURN(const auto certificate,
                            read_certificate(arguments.text("--validity-from")));
    return governance::Validity{certificate.not_before(), certificate.not_after()};
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto days, validity(arguments, now));
  return governance::Validity{days.not_before, days.not_after};
}

struct GrantOfPolicy {
  std::string name, subject;

  static constexpr auto fields() {
    return std::tuple(field<&GrantOfPolicy::name>(), field<&GrantOfPolicy::subject>());
  }
};

struct PolicyPermissions {
  fs::path file;
  std::vector<GrantOfPolicy> grants = {};

  static constexpr auto fields() {
    return std::tuple(field<&PolicyPermissions::file>(),
                      field<&PolicyPermissions::grants>({.min = 1}));
  }
  std::string text() const {
    return fmt::format("{}: {}\n", file.string(), count_text(grants.size(), "grant"));
  }
};

Result<Answer<PolicyPermissions>> from_ros_policy(const Arguments& arguments,
                                                  const Context& context) {
  const fs::path file = arguments.text("FILE");
  DDSSEC_ASSIGN_OR_RETURN(auto file_policy, read_policy(file, arguments.all("--enclave")));
  const auto policy = with_options(std::move(file_policy), arguments);
  DDSSEC_ASSIGN_OR_RETURN(const auto domain_id, domain_of(arguments));
  DDSSEC_ASSIGN_OR_RETURN(const auto validity, life(arguments, context.clock.calendar_seconds()));
  const governance::RosPermissionsOptions options{
      .domain = domain_id,
      .validity = validity,
      .discovery_topic = !arguments.has("--no-discovery-topic")};
  const bool as_sros2 = arguments.has("--sros2-order");
  const auto xml =
      as_sros2 ? sros2_permissions(policy, options) : to_xml(permissions_of(policy, options));
  DDSSEC_ASSIGN_OR_RETURN(const auto document, governance::read_permissions(as_bytes(xml)));
  auto findings = lint(document, {.now = context.clock.calendar_seconds()});
  for (auto& finding : findings) finding.severity = std::min(finding.severity, Severity::warning);
  Answer<PolicyPermissions> out{};
  auto& report = out.report;
  if (!as_sros2) add_findings(report, merged_profiles(policy), file);
  add_findings(report, prefixed_names(policy), file);
  DDSSEC_ASSIGN_OR_RETURN(report.files_written, write_document(xml, arguments, context));
  add_findings(report, std::move(findings), report.files_written.front().path);
  out.result.file = report.files_written.front().path;
  for (const auto& grant : document.grants)
    out.result.grants.push_back({grant.name, grant.subject_name});
  return out;
}

}  // namespace

std::vector<Command> ros_policy_commands() {
  return {{.group = "permissions",
           .name = "from-ros-policy",
           .summary = "Writes the permissions that result from a ROS 2 policy (sros2).",
           .positionals = {{"FILE", "the policy; what it includes is read from below its folder"}},
           .options = with_signing_options(
               {{.name = "-o", .value = "FILE", .summary = "the new document", .required = true},
                kDomain,
                repeated("--enclave", "PATH", "this enclave only"),
                {"--validity-from", "CERT", "valid as long as this certificate"},
                days("365"),
                kNodeDefaults,
                {"--no-discovery-topic", "", "do not allow ros_discovery_info"},
                {"--sros2-order", "", "octet for octet as sros2 writes it"}}),
           .examples = {"ddssec permissions from-ros-policy policy.xml --enclave /talker "
                        "--validity-from cert.pem -o permissions.xml",
                        "ddssec permissions from-ros-policy policy.xml --node-defaults -o "
                        "permissions.xml"},
           .run = from_ros_policy}};
}

}  // namespace ddssec::cli
