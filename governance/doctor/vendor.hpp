// The products whose reading of a participant's folder is predicted, and the prediction.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace ddssec::governance::doctor {

/// A DDS product with its security plugins. What is known of each was measured against the product
/// itself (tests/interop).
enum class Vendor : std::uint8_t {
  cyclonedds,  ///< Cyclone DDS 0.10.2 with its own plugins
  fastdds,     ///< Fast DDS 2.9.1
  ours,        ///< the plugins of ddssec
};
inline constexpr std::array kVendors{Vendor::cyclonedds, Vendor::fastdds, Vendor::ours};

/// "cyclonedds@0.10.2", "fastdds@2.9.1", "ours".
std::string_view id(Vendor vendor);
/// "Cyclone DDS 0.10.2" and so on.
std::string_view name(Vendor vendor);

/// As columns show it to people: the id, and "ddssec" for ours, whose id is part of the JSON
/// contract.
std::string_view label(Vendor vendor);
/// From an id, with or without its version. Nothing if it is neither.
std::optional<Vendor> vendor_from(std::string_view text);

/// What comes of something with one product, from good to bad.
enum class Outcome : std::uint8_t {
  ok,
  unsafe,  ///< it is believed and must not be
  late,    ///< the participant comes up, and then it or its endpoints are refused
  fail,    ///< the participant does not come up
};
/// "ok", "unsafe", "late", "fail".
std::string_view to_string(Outcome outcome);

/// One outcome for each product.
struct Outcomes {
  Outcome cyclonedds = Outcome::ok;
  Outcome fastdds = Outcome::ok;
  Outcome ours = Outcome::ok;

  /// The same for all.
  static constexpr Outcomes all(Outcome outcome) { return {outcome, outcome, outcome}; }
  constexpr Outcome of(Vendor vendor) const {
    return vendor == Vendor::cyclonedds ? cyclonedds : vendor == Vendor::fastdds ? fastdds : ours;
  }
  /// The worse of both, for each product.
  Outcomes worse(const Outcomes& other) const;
  bool all_ok() const { return *this == Outcomes{}; }
  bool operator==(const Outcomes&) const = default;
};

}  // namespace ddssec::governance::doctor
