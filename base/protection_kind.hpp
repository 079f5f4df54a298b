// ProtectionKind: the type that governance documents, security attributes and transforms share.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

namespace ddssec {

/// ProtectionKind (DDS-Security 1.2, clause 10.4.1.2.2).
enum class ProtectionKind : std::uint8_t {
  none,
  sign,
  encrypt,
  sign_with_origin_authentication,
  encrypt_with_origin_authentication,
};

constexpr bool is_protected(ProtectionKind kind) { return kind != ProtectionKind::none; }
constexpr bool is_encrypted(ProtectionKind kind) {
  return kind == ProtectionKind::encrypt ||
         kind == ProtectionKind::encrypt_with_origin_authentication;
}
constexpr bool is_origin_authenticated(ProtectionKind kind) {
  return kind >= ProtectionKind::sign_with_origin_authentication;
}

/// Returns the spelling of governance documents, such as "ENCRYPT_WITH_ORIGIN_AUTHENTICATION".
std::string_view to_string(ProtectionKind kind);
/// Parses that spelling, upper case only; empty for any other text.
std::optional<ProtectionKind> protection_kind_from(std::string_view text);

}  // namespace ddssec
