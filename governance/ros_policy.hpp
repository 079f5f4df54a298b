// ROS 2 access policies (sros2's policy.xml), and their conversion to DDS permissions.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/bytes.hpp"
#include "base/result.hpp"
#include "governance/model.hpp"

namespace ddssec::governance {

/// The subject of a policy element.
enum class RosKind : std::uint8_t { topics, services, actions };
/// True or false, or `unsaid` if there is no attribute.
enum class RosQualifier : std::uint8_t { unsaid, allow, deny };

/// One <topics>, <services> or <actions> element.
struct RosElement {
  RosKind kind = RosKind::topics;
  /// publish, reply or call.
  RosQualifier first = RosQualifier::unsaid;
  /// subscribe, request or execute.
  RosQualifier second = RosQualifier::unsaid;
  std::vector<std::string> names = {};  ///< as written, including blanks
};

/// One node.
struct RosProfile {
  std::string ns, node;
  std::vector<RosElement> elements = {};
};

/// One enclave; each <profiles> element is a separate list.
struct RosEnclave {
  std::string path;
  std::vector<std::vector<RosProfile>> profiles = {};
  int line = 0;
};

/// A policy file of SROS 2: what each enclave may do.
struct RosPolicy {
  std::vector<RosEnclave> enclaves = {};
};

/// Limits for XInclude.
inline constexpr int kMaxIncludeDepth = 8;
inline constexpr int kMaxIncludes = 256;

/// Reads a file; errors name the file.
using ReadFile = std::function<Result<Bytes>(const std::filesystem::path&)>;

/// Reads a policy of version 0.2.0. xi:include elements of either namespace are replaced by the
/// content that they name: files below the including file's folder, selected by an xpointer of
/// element names such as `xpointer(/profile/*)`. Errors: those of `read` and XmlDocument::parse,
/// document_kind, element_*, attribute_unknown, policy_value, policy_include.
Result<RosPolicy> read_ros_policy(const std::filesystem::path& file, const ReadFile& read);

/// Returns the expanded name of a ROS name, as a node of the profile uses it: absolute, `~`, or
/// relative.
std::string expanded_ros_name(const RosProfile& profile, std::string_view name);

/// What a policy does not say, but permissions need.
struct RosPermissionsOptions {
  DomainId domain = 0;
  Validity validity = {};
  bool discovery_topic = true;  ///< allow ros_discovery_info, as ROS 2 needs
};

/// Returns one grant for each enclave, with CN= and the path as subject. The contents of several
/// <profiles> are merged. Denials come first; expressions are sorted, without duplicates.
Permissions permissions_of(const RosPolicy& policy, const RosPermissionsOptions& options);

/// Returns the same as XML, octet for octet as sros2 0.13 writes it: one grant for each <profiles>
/// element, names in its order, no XML declaration, times without a zone.
std::string sros2_permissions(const RosPolicy& policy, const RosPermissionsOptions& options);

}  // namespace ddssec::governance
