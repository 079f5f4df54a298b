#include "cli/snippets.hpp"

#include <system_error>

#include <fmt/format.h>

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

std::string xml_path(const fs::path& path) {
  std::error_code ignored;
  std::string out;
  for (const char c : fs::absolute(path, ignored).lexically_normal().string()) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else
      out += c;
  }
  return out;
}

std::string library(std::string_view name, std::string_view what) {
  return fmt::format(
      "<Library path=\"dds_security_{}\" initFunction=\"init_{}\" "
      "finalizeFunction=\"finalize_{}\"/>",
      name, what, what);
}

std::string property(std::string_view name, const std::string& value) {
  return fmt::format("      <property><name>{}</name><value>{}</value></property>\n", name, value);
}

}  // namespace

std::string cyclonedds_snippet(const pki::ParticipantFolder& folder) {
  const auto element = [](std::string_view name, const fs::path& path) {
    return fmt::format("      <{}>file:{}</{}>\n", name, xml_path(path), name);
  };
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\"><Security>\n"
      "    <Authentication>\n      {}\n{}{}{}{}    </Authentication>\n"
      "    <Cryptographic>\n      {}\n    </Cryptographic>\n"
      "    <AccessControl>\n      {}\n{}{}{}    </AccessControl>\n"
      "</Security></Domain></CycloneDDS>\n",
      library("auth", "authentication"), element("IdentityCA", folder.identity_ca),
      element("IdentityCertificate", folder.certificate), element("PrivateKey", folder.key),
      element("CRL", folder.crl), library("crypto", "crypto"), library("ac", "access_control"),
      element("PermissionsCA", folder.permissions_ca), element("Governance", folder.governance),
      element("Permissions", folder.permissions));
}

std::string fastdds_snippet(const pki::ParticipantFolder& folder) {
  const auto file = [](const fs::path& path) { return "file://" + xml_path(path); };
  const std::string pki = "dds.sec.auth.builtin.PKI-DH.";
  const std::string access = "dds.sec.access.builtin.Access-Permissions.";
  return "<profiles xmlns=\"http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles\">\n"
         "  <participant profile_name=\"secured\" is_default_profile=\"true\"><rtps>\n"
         "    <propertiesPolicy><properties>\n" +
         property("dds.sec.auth.plugin", "builtin.PKI-DH") +
         property(pki + "identity_ca", file(folder.identity_ca)) +
         property(pki + "identity_certificate", file(folder.certificate)) +
         property(pki + "private_key", file(folder.key)) +
         property(pki + "identity_crl", file(folder.crl)) +
         property("dds.sec.access.plugin", "builtin.Access-Permissions") +
         property(access + "permissions_ca", file(folder.permissions_ca)) +
         property(access + "governance", file(folder.governance)) +
         property(access + "permissions", file(folder.permissions)) +
         property("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC") +
         "    </properties></propertiesPolicy>\n  </rtps></participant>\n</profiles>\n";
}

std::string ros2_snippet(const fs::path& keystore, const std::string& enclave) {
  std::error_code ignored;
  return fmt::format(
      "export ROS_SECURITY_ENABLE=true ROS_SECURITY_STRATEGY=Enforce\n"
      "export ROS_SECURITY_KEYSTORE=\"{}\"\n"
      "ros2 run PACKAGE NODE --ros-args --enclave {}\n",
      fs::absolute(keystore, ignored).lexically_normal().string(), enclave);
}

}  // namespace ddssec::cli
