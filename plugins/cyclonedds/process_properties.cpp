#include "plugins/cyclonedds/process_properties.hpp"

#include <cstdlib>
#include <string_view>

#include "plugins/spi/property_file.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cyclonedds {
namespace {

namespace property = spi::property;

/// Cyclone DDS's core cannot protect messages before authentication.
constexpr std::string_view kOfPreSharedKeys[] = {
    property::kPskPassphrase, property::kPskExtraPassphrases, property::kPskCipher};

std::string_view variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

Result<spi::PropertyList> process_properties() {
  spi::PropertyList out;
  if (const auto file = variable(kPropertiesVariable); !file.empty()) {
    DDSSEC_ASSIGN_OR_RETURN(out, spi::read_property_file(file));
  }
  const auto cipher = variable(kCipherVariable);
  if (cipher.empty()) return out;
  std::erase_if(out, [](const auto& one) { return one.name == spi::property::kSymmetricCipher; });
  out.push_back({std::string(spi::property::kSymmetricCipher), std::string(cipher), false});
  return out;
}

}  // namespace

Result<spi::PropertyList> with_process_properties(spi::PropertyList of_host) {
  DDSSEC_ASSIGN_OR_RETURN(auto property_list, process_properties());
  for (auto& one : property_list) {
    if (!spi::property_value(of_host, one.name).empty()) continue;
    // Cyclone DDS passes an empty value for an element that its configuration leaves out.
    std::erase_if(of_host, [&](const auto& named) { return named.name == one.name; });
    of_host.push_back(std::move(one));
  }
  for (const auto name : kOfPreSharedKeys)
    if (!spi::property_value(of_host, name).empty())
      return fail(Code::property_without_effect,
                  {.document = std::string(name),
                   .note = "Cyclone DDS cannot use pre-shared keys",
                   .hint = "remove the property, or use ddssec's embedded participant"});
  return of_host;
}

}  // namespace ddssec::cyclonedds
