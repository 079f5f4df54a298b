#include "plugins/spi/flag_property.hpp"

namespace ddssec::spi {

Result<bool> flag_property(const PropertyList& properties, std::string_view name) {
  const auto* const text = find_property(properties, name);
  if (text == nullptr || *text == "false") return false;
  if (*text == "true") return true;
  return fail(
      Code::invalid_property,
      {.document = std::string(name), .expected = "true or false", .found = text->substr(0, 64)});
}

}  // namespace ddssec::spi
