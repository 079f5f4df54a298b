#include "plugins/spi/process_properties.hpp"

#include <cstdlib>
#include <string_view>

#include "plugins/spi/clock_step_grace.hpp"
#include "plugins/spi/flag_property.hpp"
#include "plugins/spi/property_file.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::spi {
namespace {

// These need protection before authentication, which Cyclone DDS's core does not support.
constexpr std::string_view kOfPreSharedKeys[] = {
    property::kPskPassphrase, property::kPskExtraPassphrases, property::kPskCipher};

std::string_view variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

Result<PropertyList> process_properties() {
  PropertyList out;
  if (const auto file = variable(kPropertiesVariable); !file.empty()) {
    DDSSEC_ASSIGN_OR_RETURN(out, read_property_file(file));
  }
  const auto cipher = variable(kCipherVariable);
  if (cipher.empty()) return out;
  std::erase_if(out, [](const auto& one) { return one.name == property::kSymmetricCipher; });
  out.push_back({std::string(property::kSymmetricCipher), std::string(cipher), false});
  return out;
}

}  // namespace

Result<PropertyList> with_process_properties(PropertyList of_host) {
  DDSSEC_ASSIGN_OR_RETURN(auto property_list, process_properties());
  for (auto& one : property_list) {
    if (!property_value(of_host, one.name).empty()) continue;
    // Cyclone DDS passes an empty value for an element that its configuration leaves out.
    std::erase_if(of_host, [&](const auto& named) { return named.name == one.name; });
    of_host.push_back(std::move(one));
  }
  for (const auto name : kOfPreSharedKeys)
    if (!property_value(of_host, name).empty())
      return fail(Code::property_without_effect,
                  {.document = std::string(name),
                   .note = "Cyclone DDS cannot use pre-shared keys",
                   .hint = "remove the property, or use ddssec's embedded participant"});
  return of_host;
}

Status check_properties_of_adapters(const PropertyList& properties) {
  DDSSEC_RETURN_IF_ERROR(clock_step_grace(properties));
  for (const auto name : {property::kAllowSharedMemory, property::kTrustTypeInformation})
    DDSSEC_RETURN_IF_ERROR(flag_property(properties, name));
  return {};
}

}  // namespace ddssec::spi
