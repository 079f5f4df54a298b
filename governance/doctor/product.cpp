#include "governance/doctor/product.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

namespace ddssec::governance::doctor {
namespace {

constexpr std::array<std::string_view, 3> kNames{"cyclonedds", "fastdds", "ddssec"};
constexpr std::array<std::string_view, 3> kFamilies{"Cyclone DDS", "Fast DDS", "ddssec's plugins"};

std::string_view short_name(Vendor vendor) { return kNames.at(static_cast<std::size_t>(vendor)); }

std::optional<Vendor> vendor_named(std::string_view text) {
  if (text == "ours") return Vendor::ddssec;
  const auto found = std::ranges::find(kVendors, text, short_name);
  return found == kVendors.end() ? std::nullopt : std::optional(*found);
}

}  // namespace

std::string to_string(Version version) {
  return fmt::format("{}.{}.{}", version.major, version.minor, version.patch);
}

std::optional<Version> version_from(std::string_view text) {
  constexpr int kMax = 9999;
  Version out;
  for (int* const part : {&out.major, &out.minor, &out.patch}) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *part);
    if (error != std::errc() || text.starts_with('-') || *part > kMax) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    if (text.empty()) return out;
    if (!text.starts_with('.')) return std::nullopt;
    text.remove_prefix(1);
  }
  return std::nullopt;
}

std::string id(Vendor vendor, const Lineup& lineup) {
  if (vendor == Vendor::ddssec) return std::string(short_name(vendor));
  return fmt::format("{}@{}", short_name(vendor), to_string(lineup.of(vendor)));
}

std::string_view family(Vendor vendor) { return kFamilies.at(static_cast<std::size_t>(vendor)); }

std::string name(Vendor vendor, const Lineup& lineup) {
  if (vendor == Vendor::ddssec) return std::string(family(vendor));
  return fmt::format("{} {}", family(vendor), to_string(lineup.of(vendor)));
}

std::optional<NamedProduct> product_from(std::string_view text) {
  const auto at = text.find('@');
  const auto vendor = vendor_named(text.substr(0, at));
  if (!vendor) return std::nullopt;
  if (at == text.npos) return NamedProduct{*vendor};
  const auto version = version_from(text.substr(at + 1));
  if (!version || *vendor == Vendor::ddssec) return std::nullopt;
  return NamedProduct{*vendor, version};
}

std::optional<Vendor> vendor_from(std::string_view text) {
  const auto product = product_from(text);
  return product ? std::optional(product->vendor) : std::nullopt;
}

std::string_view to_string(Outcome outcome) {
  constexpr std::array<std::string_view, 4> kWords{"ok", "unsafe", "late", "fail"};
  return kWords.at(static_cast<std::size_t>(outcome));
}

Outcomes Outcomes::worse(const Outcomes& other) const {
  return {std::max(cyclonedds, other.cyclonedds), std::max(fastdds, other.fastdds),
          std::max(ddssec, other.ddssec)};
}

}  // namespace ddssec::governance::doctor
