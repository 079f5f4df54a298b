#include "base/property.hpp"

#include <algorithm>
#include <cstdint>

#include "base/hash.hpp"

namespace ddssec {

Property::~Property() {
  void* const octets = value.data();
  wipe({static_cast<std::uint8_t*>(octets), value.size()});
}

const std::string* find_property(const PropertyList& properties, std::string_view name) {
  const auto found = std::ranges::find(properties, name, &Property::name);
  return found == properties.end() ? nullptr : &found->value;
}

std::string_view property_value(const PropertyList& properties, std::string_view name) {
  const auto* const value = find_property(properties, name);
  return value == nullptr ? std::string_view() : std::string_view(*value);
}

}  // namespace ddssec
