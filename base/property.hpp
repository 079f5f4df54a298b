// Pairs of a name and a value: properties of an entity, data tags.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ddssec {

/// Property_t (DDS-Security 1.2, clause 7.3.2). `propagate` says whether it goes on the wire.
struct Property {
  std::string name;
  std::string value;
  bool propagate = true;
  bool operator==(const Property&) const = default;
  /// Wipes the value, which may be a passphrase. (There is no move: copies wipe themselves too.)
  ~Property();
};

using PropertyList = std::vector<Property>;

/// The value of the first property with that name, or nullptr. Owned by `properties`.
const std::string* find_property(const PropertyList& properties, std::string_view name);
/// The same as a view; empty if there is none. Valid as long as `properties`.
std::string_view property_value(const PropertyList& properties, std::string_view name);

}  // namespace ddssec
