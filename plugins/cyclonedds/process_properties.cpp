#include "plugins/cyclonedds/process_properties.hpp"

#include <cstdlib>
#include <string_view>

#include "plugins/spi/property_file.hpp"
#include "plugins/spi/property_names.hpp"

namespace ddssec::cyclonedds {
namespace {

std::string_view variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? std::string_view() : value;
}

}  // namespace

Result<spi::PropertyList> process_properties() {
  spi::PropertyList out;
  if (const auto file = variable(kPropertiesVariable); !file.empty())
    out = DDSSEC_TRY(spi::read_property_file(file));
  const auto cipher = variable(kCipherVariable);
  if (cipher.empty()) return out;
  std::erase_if(out, [](const auto& one) { return one.name == spi::property::kSymmetricCipher; });
  out.push_back({std::string(spi::property::kSymmetricCipher), std::string(cipher), false});
  return out;
}

Result<spi::PropertyList> with_process_properties(spi::PropertyList of_host) {
  for (auto& one : DDSSEC_TRY(process_properties()))
    if (spi::find_property(of_host, one.name) == nullptr) of_host.push_back(std::move(one));
  return of_host;
}

}  // namespace ddssec::cyclonedds
