// The products whose reading of a participant's folder is predicted, and the prediction.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ddssec::governance::doctor {

/// A DDS product with its security plugins. What is known of each was measured against the product
/// itself (governance/doctor/measured.def).
enum class Vendor : std::uint8_t {
  cyclonedds,  ///< Cyclone DDS with its own plugins
  fastdds,     ///< Fast DDS
  ours,        ///< the plugins of ddssec
};
inline constexpr std::array kVendors{Vendor::cyclonedds, Vendor::fastdds, Vendor::ours};

/// A product's version.
struct Version {
  int major = 0;
  int minor = 0;
  int patch = 0;
  auto operator<=>(const Version&) const = default;
};
/// "0.10.2".
std::string to_string(Version version);
/// From one to three numbers with dots between them. Nothing if it is something else.
std::optional<Version> version_from(std::string_view text);

/// The versions that are predicted. Without others, those that Debian 12 has.
struct Lineup {
  Version cyclonedds = {0, 10, 2};
  Version fastdds = {2, 9, 1};

  /// Of the stock product; ours has none.
  Version& of(Vendor vendor) { return vendor == Vendor::fastdds ? fastdds : cyclonedds; }
  const Version& of(Vendor vendor) const {
    return vendor == Vendor::fastdds ? fastdds : cyclonedds;
  }
  bool operator==(const Lineup&) const = default;
};

/// "cyclonedds@0.10.2", "fastdds@2.9.1", "ours".
std::string id(Vendor vendor, const Lineup& lineup = {});
/// "Cyclone DDS 0.10.2" and so on.
std::string name(Vendor vendor, const Lineup& lineup = {});
/// "Cyclone DDS", "Fast DDS", "ddssec's plugins".
std::string_view family(Vendor vendor);

/// As columns show it to people: the id, and "ddssec" for ours, whose id is part of the JSON
/// contract.
std::string label(Vendor vendor, const Lineup& lineup = {});

/// A product by its name and, if given, its version.
struct NamedProduct {
  Vendor vendor;
  std::optional<Version> version = std::nullopt;
  bool operator==(const NamedProduct&) const = default;
};
/// From NAME or NAME@VERSION. Nothing if it is neither; ours has no version.
std::optional<NamedProduct> product_from(std::string_view text);
/// The product's vendor. Nothing if `text` names none.
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
/// With no product the participant comes up.
inline constexpr Outcomes kNobody = Outcomes::all(Outcome::fail);

}  // namespace ddssec::governance::doctor
