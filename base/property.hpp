// Pairs of a name and a value: properties of an entity, and data tags.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace ddssec {

/// Property_t (DDS-Security 1.2, clause 7.3.2). If `propagate` is true, it is sent to peers.
struct Property {
  std::string name;
  std::string value;
  bool propagate = true;
  bool operator==(const Property&) const = default;
  /// Wipes the value, which may be a passphrase. There is no move constructor: each copy wipes
  /// itself.
  ~Property();
};

using PropertyList = std::vector<Property>;

/// Returns the value of the first property with that name, or nullptr. Owned by `properties`.
const std::string* find_property(const PropertyList& properties, std::string_view name);
/// Returns the same as a view; empty if there is none. Valid as long as `properties`.
std::string_view property_value(const PropertyList& properties, std::string_view name);

}  // namespace ddssec
