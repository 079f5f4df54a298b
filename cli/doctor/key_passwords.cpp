#include "cli/doctor/key_passwords.hpp"

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>

#include "base/text.hpp"
#include "base/uri_source.hpp"
#include "cli/doctor/folder_configuration.hpp"
#include "cli/inputs/files.hpp"
#include "governance/doctor/configuration_checks.hpp"
#include "governance/doctor/cyclonedds_configuration.hpp"
#include "pki/certificate_source.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cli {
namespace {

namespace doctor = governance::doctor;
namespace fs = std::filesystem;
using doctor::LoadedFolder;

constexpr std::string_view kFastDdsPassword = "dds.sec.auth.builtin.PKI-DH.password";

// Takes the first password of any domain. If there are several, this does not judge which one
// counts.
std::string password_for_cyclonedds(const LoadedFolder& folder) {
  const auto file = configuration_in(folder.paths.folder);
  auto configuration = doctor::cyclonedds_configuration();
  if (!configuration && path_exists(file))
    configuration = doctor::cyclonedds_configuration(file.string());
  if (!configuration) return {};
  const auto text = doctor::without_comments(*configuration);
  const auto tag = doctor::find_tag(text, "password");
  return tag ? std::string(trimmed(tag->after.substr(0, tag->after.find('<')), " \t\r\n"))
             : std::string();
}

std::string password_for_fastdds(const LoadedFolder& folder) {
  const auto file = folder.paths.folder / "fastdds.xml";
  const auto octets = ddssec::load_uri("file://" + file.string(), "", pki::kMaxDocumentOctets);
  if (!octets) return {};
  const auto properties = doctor::properties_of_profile(as_text(*octets));
  if (!properties) return {};
  const auto found = std::ranges::find(*properties, kFastDdsPassword,
                                       &doctor::ProfileProperties::value_type::first);
  return found == properties->end() ? std::string() : found->second;
}

std::string password_for_embedded(const LoadedFolder& folder) {
  const auto properties = readable_properties(folder.paths);
  return std::string(spi::property_value(properties, spi::property::kPassword));
}

// Keeps the opened key. The password is held in a property, which wipes its value when it is
// destroyed.
bool open_key_with(std::string password, LoadedFolder& folder) {
  const spi::Property property{std::string(spi::property::kPassword), std::move(password), false};
  const auto passphrase = pki::Passphrase::copy_of(as_bytes(property.value));
  if (property.value.empty() || !passphrase) return false;
  auto key = pki::PrivateKey::load("file://" + folder.paths.key.string(), folder.paths.key.string(),
                                   &*passphrase);
  if (!key) return false;
  folder.key = std::move(key);
  return true;
}

}  // namespace

void open_key(LoadedFolder& folder) {
  if (folder.key || folder.key.error().code() != Code::passphrase_missing) return;
  doctor::PasswordGiven given;
  given.has_cyclonedds = open_key_with(password_for_cyclonedds(folder), folder);
  given.has_fastdds = open_key_with(password_for_fastdds(folder), folder);
  given.has_ddssec = open_key_with(password_for_embedded(folder), folder) || given.has_cyclonedds;
  if (folder.key) folder.password = given;
}

}  // namespace ddssec::cli
