#include "base/protection_kind.hpp"

#include <algorithm>
#include <array>

namespace ddssec {
namespace {

constexpr std::array<std::string_view, 5> kNames = {"NONE", "SIGN", "ENCRYPT",
                                                    "SIGN_WITH_ORIGIN_AUTHENTICATION",
                                                    "ENCRYPT_WITH_ORIGIN_AUTHENTICATION"};

}  // namespace

std::string_view to_string(ProtectionKind kind) {
  return kNames.at(static_cast<std::size_t>(kind));
}

std::optional<ProtectionKind> protection_kind_from(std::string_view text) {
  const auto found = std::ranges::find(kNames, text);
  if (found == kNames.end()) return std::nullopt;
  return static_cast<ProtectionKind>(found - kNames.begin());
}

}  // namespace ddssec
