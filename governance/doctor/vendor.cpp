#include "governance/doctor/vendor.hpp"

#include <algorithm>

namespace ddssec::governance::doctor {

std::string_view id(Vendor vendor) {
  constexpr std::array<std::string_view, 3> kIds{"cyclonedds@0.10.2", "fastdds@2.9.1", "ours"};
  return kIds.at(static_cast<std::size_t>(vendor));
}

std::string_view name(Vendor vendor) {
  constexpr std::array<std::string_view, 3> kNames{"Cyclone DDS 0.10.2", "Fast DDS 2.9.1",
                                                   "ddssec's plugins"};
  return kNames.at(static_cast<std::size_t>(vendor));
}

std::string_view label(Vendor vendor) { return vendor == Vendor::ours ? "ddssec" : id(vendor); }

std::optional<Vendor> vendor_from(std::string_view text) {
  const auto found = std::ranges::find_if(kVendors, [&](Vendor vendor) {
    return text == id(vendor) || text == label(vendor) ||
           text == id(vendor).substr(0, id(vendor).find('@'));
  });
  return found == kVendors.end() ? std::nullopt : std::optional(*found);
}

std::string_view to_string(Outcome outcome) {
  constexpr std::array<std::string_view, 4> kWords{"ok", "unsafe", "late", "fail"};
  return kWords.at(static_cast<std::size_t>(outcome));
}

Outcomes Outcomes::worse(const Outcomes& other) const {
  return {std::max(cyclonedds, other.cyclonedds), std::max(fastdds, other.fastdds),
          std::max(ours, other.ours)};
}

}  // namespace ddssec::governance::doctor
