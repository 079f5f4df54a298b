#include "secured/engines.hpp"

#include <algorithm>
#include <iterator>

#include "pki/participant_folder.hpp"
#include "pki/source.hpp"
#include "plugins/spi/clock_step_grace.hpp"
#include "plugins/spi/property_file.hpp"
#include "plugins/spi/property_names.hpp"
#include "secured/folder_check.hpp"

namespace ddssec::secured {

Status Engines::set_clock_step_grace(const spi::PropertyList& properties) {
  DDSSEC_ASSIGN_OR_RETURN(const auto grace, spi::clock_step_grace(properties));
  calendar_.set_grace(grace);
  return {};
}

Result<spi::PropertyList> folder_properties(const std::filesystem::path& path) {
  namespace property = spi::property;
  DDSSEC_RETURN_IF_ERROR(check_is_participant(path));
  std::error_code error;
  const auto folder = pki::participant_folder(path);
  spi::PropertyList out;
  const auto add = [&](std::string_view name, const std::filesystem::path& file) {
    out.push_back({std::string(name), "file:" + file.string(), false});
  };
  const auto add_item = [&](std::string_view name, const std::filesystem::path& file) -> Status {
    DDSSEC_ASSIGN_OR_RETURN(auto uri, pki::uri_of(file));
    out.push_back({std::string(name), std::move(uri), false});
    return {};
  };
  DDSSEC_RETURN_IF_ERROR(add_item(property::kIdentityCa, folder.identity_ca));
  DDSSEC_RETURN_IF_ERROR(add_item(property::kIdentityCertificate, folder.certificate));
  DDSSEC_RETURN_IF_ERROR(add_item(property::kPrivateKey, folder.key));
  DDSSEC_RETURN_IF_ERROR(add_item(property::kPermissionsCa, folder.permissions_ca));
  add(property::kGovernance, folder.governance);
  add(property::kPermissions, folder.permissions);
  // A dangling symbolic link counts as present: a file was meant to be there.
  const auto is_meant = [&](const std::filesystem::path& file) {
    return std::filesystem::symlink_status(file, error).type() >
           std::filesystem::file_type::not_found;
  };
  add(is_meant(folder.crl) ? property::kCrl : property::kLaterCrl, folder.crl);
  if (!is_meant(folder.properties)) return out;
  DDSSEC_ASSIGN_OR_RETURN(auto file_properties, spi::read_property_file(folder.properties));
  const auto without_effect = [&](const std::string& name, std::string why) {
    return fail(Code::property_without_effect,
                {.document = folder.properties.string(), .field = name, .note = std::move(why)});
  };
  for (auto& further : file_properties) {
    if (spi::find_property(out, further.name) != nullptr)
      return without_effect(further.name, "a file of the folder goes before it");
    out.push_back(std::move(further));
  }
  return out;
}

}  // namespace ddssec::secured
