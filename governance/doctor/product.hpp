// The products for which the use of a participant's folder is predicted, and the prediction.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ddssec::governance::doctor {

/// A DDS product with its security plugins. Its behaviour was measured with the product itself
/// (governance/doctor/measured_outcomes.def).
enum class Product : std::uint8_t {
  cyclonedds,  ///< Cyclone DDS with its own plugins
  fastdds,     ///< Fast DDS
  ddssec,      ///< the plugins of ddssec
};
inline constexpr std::array kProducts{Product::cyclonedds, Product::fastdds, Product::ddssec};

/// A product's version.
struct Version {
  int major = 0;
  int minor = 0;
  int patch = 0;
  auto operator<=>(const Version&) const = default;
};
/// Returns a text such as "0.10.2".
std::string to_string(Version version);
/// Reads one to three numbers separated by dots; empty for anything else.
std::optional<Version> version_from(std::string_view text);

/// The versions for which to predict. The defaults are those of Debian 12.
struct Lineup {
  Version cyclonedds = {0, 10, 2};
  Version fastdds = {2, 9, 1};

  /// Returns the version of the stock product; ddssec has none.
  Version& of(Product product) { return product == Product::fastdds ? fastdds : cyclonedds; }
  const Version& of(Product product) const {
    return product == Product::fastdds ? fastdds : cyclonedds;
  }
  bool operator==(const Lineup&) const = default;
};

/// Returns "cyclonedds@0.10.2", "fastdds@2.9.1" or "ddssec", with the versions of the lineup.
std::string id(Product product, const Lineup& lineup = {});
/// Returns a text such as "Cyclone DDS 0.10.2".
std::string name(Product product, const Lineup& lineup = {});
/// Returns "Cyclone DDS", "Fast DDS" or "ddssec's plugins".
std::string_view family(Product product);

/// How Fast DDS finds its default profiles. Fast DDS 3 renamed both; version 3.1 was not run to
/// confirm that.
struct ProfilePlaces {
  const char* variable;  ///< an environment variable that names a file
  const char* file;      ///< a file in the working directory, which is read after the other one
};
constexpr ProfilePlaces profile_places(Version fastdds) {
  return fastdds.major < 3
             ? ProfilePlaces{"FASTRTPS_DEFAULT_PROFILES_FILE", "DEFAULT_FASTRTPS_PROFILES.xml"}
             : ProfilePlaces{"FASTDDS_DEFAULT_PROFILES_FILE", "DEFAULT_FASTDDS_PROFILES.xml"};
}

/// The octets of certificate and signed permissions, which one handshake message holds, with which
/// Fast DDS is known to authenticate another Fast DDS participant. Measured with 2.9.1: 63,705
/// octets work, and 63,764 do not. The size of the rest of the message varies a little.
inline constexpr std::size_t kMaxFastDdsHandshakeOctets = 63'000;

/// A product by its name and, if given, its version.
struct NamedProduct {
  Product name;
  std::optional<Version> version = std::nullopt;
  bool operator==(const NamedProduct&) const = default;
};
/// Reads NAME or NAME@VERSION; empty for anything else. ddssec has no version. "ours", its name in
/// ddssec 0.3 and earlier, is understood, too.
std::optional<NamedProduct> named_product_from(std::string_view text);
/// Returns the product; empty if `text` names none.
std::optional<Product> product_from(std::string_view text);

/// The outcome with one product, from good to bad.
enum class Outcome : std::uint8_t {
  ok,
  unsafe,  ///< the product accepts it although it must not
  late,    ///< the participant starts, and then it or its endpoints are refused
  fail,    ///< the participant does not start
};
/// Returns "ok", "unsafe", "late" or "fail".
std::string_view to_string(Outcome outcome);

/// One outcome for each product.
struct Outcomes {
  Outcome cyclonedds = Outcome::ok;
  Outcome fastdds = Outcome::ok;
  Outcome ddssec = Outcome::ok;

  /// Returns the same outcome for all products.
  static constexpr Outcomes all(Outcome outcome) { return {outcome, outcome, outcome}; }
  constexpr Outcome of(Product product) const {
    return product == Product::cyclonedds ? cyclonedds
           : product == Product::fastdds  ? fastdds
                                          : ddssec;
  }
  /// Returns the worse of both, for each product.
  Outcomes worse(const Outcomes& other) const;
  bool all_ok() const { return *this == Outcomes{}; }
  bool operator==(const Outcomes&) const = default;
};
/// The outcomes if the participant does not start with any product.
inline constexpr Outcomes kAllFail = Outcomes::all(Outcome::fail);

}  // namespace ddssec::governance::doctor
