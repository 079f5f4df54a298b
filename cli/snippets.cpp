#include "cli/snippets.hpp"

#include <system_error>

#include <fmt/format.h>

#include "pki/source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr auto kCycloneDdsFile = "cyclonedds.xml";
constexpr auto kFastDdsFile = "fastdds.xml";

std::string xml_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else
      out += c;
  }
  return out;
}

std::string whole_path(const fs::path& path) {
  std::error_code ignored;
  return fs::absolute(path, ignored).lexically_normal().string();
}

std::string xml_path(const fs::path& path) { return xml_text(whole_path(path)); }

// A key in a token has no file: what a product must be given is the key's own URI.
std::string xml_uri(const fs::path& path) {
  const auto uri = path.extension() == ".p11" ? pki::uri_of(path) : Result<std::string>();
  return uri && !uri->empty() ? xml_text(*uri) : "file:" + xml_path(path);
}

std::string library(std::string_view name, std::string_view what) {
  return fmt::format(
      "<Library path=\"dds_security_{}\" initFunction=\"init_{}\" "
      "finalizeFunction=\"finalize_{}\"/>",
      name, what, what);
}

std::string property_line(std::string_view name, const std::string& value) {
  return fmt::format("      <property><name>{}</name><value>{}</value></property>\n", name, value);
}

}  // namespace

std::array<ConfigurationFile, 2> configuration_files(const pki::ParticipantFolder& folder) {
  return {{{kCycloneDdsFile, cyclonedds_snippet(folder)}, {kFastDdsFile, fastdds_snippet(folder)}}};
}

std::string configuration_lines(std::string_view name, const fs::path& folder) {
  return fmt::format(
      "{0} with Cyclone DDS: export CYCLONEDDS_URI='file://{1}'\n"
      "{0} with Fast DDS:    export FASTRTPS_DEFAULT_PROFILES_FILE='{2}'\n",
      name, whole_path(folder / kCycloneDdsFile), whole_path(folder / kFastDdsFile));
}

std::string cyclonedds_snippet(const pki::ParticipantFolder& folder) {
  const auto element = [](std::string_view name, const fs::path& path) {
    return fmt::format("      <{}>{}</{}>\n", name, xml_uri(path), name);
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
  const auto file = [](const fs::path& path) {
    return path.extension() == ".p11" ? xml_uri(path) : "file://" + xml_path(path);
  };
  const std::string pki = "dds.sec.auth.builtin.PKI-DH.";
  const std::string access = "dds.sec.access.builtin.Access-Permissions.";
  return "<profiles xmlns=\"http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles\">\n"
         "  <participant profile_name=\"secured\" is_default_profile=\"true\"><rtps>\n"
         "    <propertiesPolicy><properties>\n" +
         property_line("dds.sec.auth.plugin", "builtin.PKI-DH") +
         property_line(pki + "identity_ca", file(folder.identity_ca)) +
         property_line(pki + "identity_certificate", file(folder.certificate)) +
         property_line(pki + "private_key", file(folder.key)) +
         property_line(pki + "identity_crl", file(folder.crl)) +
         property_line("dds.sec.access.plugin", "builtin.Access-Permissions") +
         property_line(access + "permissions_ca", file(folder.permissions_ca)) +
         property_line(access + "governance", file(folder.governance)) +
         property_line(access + "permissions", file(folder.permissions)) +
         property_line("dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC") +
         "    </properties></propertiesPolicy>\n  </rtps></participant>\n</profiles>\n";
}

std::string ros2_snippet(const fs::path& keystore, const std::string& enclave) {
  return fmt::format(
      "export ROS_SECURITY_ENABLE=true ROS_SECURITY_STRATEGY=Enforce\n"
      "export ROS_SECURITY_KEYSTORE=\"{}\"\n"
      "ros2 run PACKAGE NODE --ros-args --enclave {}\n",
      whole_path(keystore), enclave);
}

}  // namespace ddssec::cli
