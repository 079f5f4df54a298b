#include "governance/doctor/product.hpp"

#include <algorithm>
#include <charconv>

#include <fmt/format.h>

namespace ddssec::governance::doctor {
namespace {

constexpr std::array<std::string_view, 3> kNames{"cyclonedds", "fastdds", "ddssec"};
constexpr std::array<std::string_view, 3> kFamilies{"Cyclone DDS", "Fast DDS", "ddssec's plugins"};

std::string_view short_name(Product product) {
  return kNames.at(static_cast<std::size_t>(product));
}

std::optional<Product> product_named(std::string_view text) {
  if (text == "ours") return Product::ddssec;
  const auto found = std::ranges::find(kProducts, text, short_name);
  return found == kProducts.end() ? std::nullopt : std::optional(*found);
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

std::string id(Product product, const Lineup& lineup) {
  if (product == Product::ddssec) return std::string(short_name(product));
  return fmt::format("{}@{}", short_name(product), to_string(lineup.of(product)));
}

std::string_view family(Product product) { return kFamilies.at(static_cast<std::size_t>(product)); }

std::string name(Product product, const Lineup& lineup) {
  if (product == Product::ddssec) return std::string(family(product));
  return fmt::format("{} {}", family(product), to_string(lineup.of(product)));
}

std::optional<NamedProduct> named_product_from(std::string_view text) {
  const auto at = text.find('@');
  const auto product = product_named(text.substr(0, at));
  if (!product) return std::nullopt;
  if (at == text.npos) return NamedProduct{*product};
  const auto version = version_from(text.substr(at + 1));
  if (!version || *product == Product::ddssec) return std::nullopt;
  return NamedProduct{*product, version};
}

std::optional<Product> product_from(std::string_view text) {
  const auto named = named_product_from(text);
  return named ? std::optional(named->name) : std::nullopt;
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
