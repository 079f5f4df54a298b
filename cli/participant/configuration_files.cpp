#include "cli/participant/configuration_files.hpp"

#include <algorithm>
#include <system_error>

#include <fmt/format.h>

#include "base/bytes.hpp"
#include "base/shell_word.hpp"
#include "base/text.hpp"
#include "cli/inputs/files.hpp"
#include "governance/doctor/domains_of_folder.hpp"
#include "governance/doctor/library_search.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {
namespace {

namespace fs = std::filesystem;

constexpr auto kCycloneDdsFile = "cyclonedds.xml";
constexpr auto kFastDdsFile = "fastdds.xml";
constexpr auto kDropin = "DROPIN";  // stands for a folder that is not known

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

// A key in a token has no file, so the product must be given the key's own URI.
std::string xml_uri(const fs::path& path) {
  const auto uri = path.extension() == ".p11" ? pki::uri_of(path) : Result<std::string>();
  return uri && !uri->empty() ? xml_text(*uri) : "file:" + xml_path(path);
}

// Cyclone DDS replaces ${X} by the variable X and has no escape for "$". A variable without a name
// and with the default value "$" stands for it (measured).
std::string without_variables(std::string text) {
  constexpr std::string_view kBegin = "${", kInstead = "${:-$}{";
  for (auto at = text.find(kBegin); at != text.npos; at = text.find(kBegin, at + kInstead.size()))
    text.replace(at, kBegin.size(), kInstead);
  return text;
}

// The loader opens a path with a slash as it is, and searches for a name without one.
std::string library(const fs::path& dropin, std::string_view name, std::string_view what) {
  const auto path = dropin.empty() ? fmt::format("dds_security_{}", name)
                                   : (dropin / fmt::format("libdds_security_{}.so", name)).string();
  return fmt::format(
      "<Library path=\"{}\" initFunction=\"init_{}\" finalizeFunction=\"finalize_{}\"/>",
      without_variables(path), what, what);
}

std::string without_libraries(std::string_view configuration) {
  constexpr std::string_view kBegin = "<Library path=\"";
  std::string out;
  for (auto at = configuration.find(kBegin); at != configuration.npos;
       at = configuration.find(kBegin)) {
    out += configuration.substr(0, at + kBegin.size());
    configuration.remove_prefix(at + kBegin.size());
    configuration.remove_prefix(std::min(configuration.find('"'), configuration.size()));
  }
  return out.append(configuration);
}

std::string property_line(std::string_view name, const std::string& value) {
  return fmt::format("      <property><name>{}</name><value>{}</value></property>\n", name, value);
}

}  // namespace

std::array<ConfigurationFile, 2> configuration_files(const pki::ParticipantFolder& folder,
                                                     const fs::path& dropin) {
  return {{{kCycloneDdsFile, cyclonedds_snippet(folder, dropin)},
           {kFastDdsFile, fastdds_snippet(folder)}}};
}

Result<std::vector<ConfigurationFile>> missing_configuration_files(
    const pki::ParticipantFolder& folder, const fs::path& dropin) {
  DDSSEC_RETURN_IF_ERROR(check_nameable(folder.folder));
  std::vector<ConfigurationFile> out;
  for (auto& wanted : configuration_files(folder, dropin)) {
    const auto file = folder.folder / wanted.name;
    if (!path_exists(file)) {
      out.push_back(std::move(wanted));
    } else if (wanted.name == kCycloneDdsFile && !dropin.empty()) {
      DDSSEC_ASSIGN_OR_RETURN(const auto octets, read_file(file, pki::kMaxDocumentOctets));
      const auto found = as_text(octets);
      if (without_libraries(found) != without_libraries(wanted.text))
        return fail(Code::would_overwrite,
                    {.document = file,
                     .note = "it is not as ddssec wrote it",
                     .hint = "write the whole paths into its three <Library path=...> yourself, or "
                             "move it away and give the command again"});
      if (found != wanted.text) out.push_back(std::move(wanted));
    }
  }
  return out;
}

Status check_nameable(const fs::path& folder) {
  const auto path = whole_path(folder);
  if (printable(path) == path) return {};
  return fail(Code::usage,
              {.document = folder,
               .note = fmt::format("the path {} has a line break or another character that neither "
                                   "a configuration nor a line for a shell can name safely",
                                   path),
               .hint = "choose a folder whose whole path has only visible characters"});
}

std::string configuration_lines(std::string_view name, const fs::path& folder) {
  const auto fastdds = shell_word(whole_path(folder / kFastDdsFile));
  return fmt::format(
      "{} with Cyclone DDS: export CYCLONEDDS_URI={}\n"
      "{} with Fast DDS 2:  export FASTRTPS_DEFAULT_PROFILES_FILE={}\n"
      "{} with Fast DDS 3:  export FASTDDS_DEFAULT_PROFILES_FILE={}\n",
      name, shell_word("file://" + whole_path(folder / kCycloneDdsFile)), name, fastdds, name,
      fastdds);
}

std::string missing_files_text(const pki::ParticipantFolder& files) {
  std::string out;
  if (!path_exists(files.permissions_ca))
    out +=
        "no permissions_ca.pem is in it yet, since --ca has no permissions CA: copy ca.pem of the "
        "permissions CA there under this name\n";
  if (!path_exists(files.governance))
    out += "no governance.p7s is in it yet: --governance FILE copies a signed one\n";
  if (!path_exists(files.permissions))
    out +=
        "no permissions are in it yet: --publish and --subscribe, or --permissions FILE, make "
        "them\n";
  return out;
}

bool leaves_libraries_open(const fs::path& folder) {
  const auto octets = read_file(folder / kCycloneDdsFile, pki::kMaxDocumentOctets);
  return octets && as_text(*octets).find("<Library path=\"dds_security_") != std::string_view::npos;
}

std::string cyclonedds_snippet(const pki::ParticipantFolder& folder, const fs::path& dropin) {
  const auto element = [](std::string_view name, const fs::path& path) {
    return fmt::format("      <{}>{}</{}>\n", name, without_variables(xml_uri(path)), name);
  };
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\"><Security>\n"
      "    <Authentication>\n      {}\n{}{}{}{}    </Authentication>\n"
      "    <Cryptographic>\n      {}\n    </Cryptographic>\n"
      "    <AccessControl>\n      {}\n{}{}{}    </AccessControl>\n"
      "</Security></Domain></CycloneDDS>\n",
      library(dropin, "auth", "authentication"), element("IdentityCA", folder.identity_ca),
      element("IdentityCertificate", folder.certificate), element("PrivateKey", folder.key),
      element("CRL", folder.crl), library(dropin, "crypto", "crypto"),
      library(dropin, "ac", "access_control"), element("PermissionsCA", folder.permissions_ca),
      element("Governance", folder.governance), element("Permissions", folder.permissions));
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

std::string ros2_snippet(const fs::path& keystore, const std::string& enclave,
                         const std::vector<governance::DomainRange>& domains) {
  const auto dropin = governance::doctor::own_dropin();
  const bool is_in_domain_0 = domains.empty() || governance::doctor::contains(domains, 0);
  return fmt::format(
      "# after sourcing setup.bash of ROS 2, which sets LD_LIBRARY_PATH{}:\n"
      "export ROS_SECURITY_ENABLE=true ROS_SECURITY_STRATEGY=Enforce\n"
      "export ROS_SECURITY_KEYSTORE={}\n"
      "export RMW_IMPLEMENTATION=rmw_cyclonedds_cpp\n"
      "{}\n{}"
      "ros2 run PACKAGE NODE --ros-args --enclave {}\n",
      dropin.empty() ? fmt::format(". {} is the folder with ddssec's libdds_security_*.so", kDropin)
                     : std::string(),
      shell_word(whole_path(keystore)),
      governance::doctor::library_path_line(dropin.empty() ? kDropin : dropin),
      is_in_domain_0 ? std::string()
                     : fmt::format("export ROS_DOMAIN_ID={}\n", domains.front().first),
      enclave);
}

}  // namespace ddssec::cli
