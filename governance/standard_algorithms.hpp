// The algorithms that DDS-Security 1.2 names (8.1, 8.2).
#pragma once

#include <array>
#include <string_view>

namespace ddssec::governance {

inline constexpr std::array<std::string_view, 4> kStandardSignatures = {
    "RSASSA-PSS-MGF1SHA256+2048+SHA256", "RSASSA-PKCS1-V1_5+2048+SHA256", "ECDSA+P256+SHA256",
    "ECDSA+P384+SHA384"};
inline constexpr std::array<std::string_view, 3> kStandardKeyEstablishments = {
    "DHE+MODP-2048-256", "ECDHE-CEUM+P256", "ECDHE-CEUM+P384"};
inline constexpr std::array<std::string_view, 2> kStandardCiphers = {"AES128+GCM", "AES256+GCM"};

}  // namespace ddssec::governance
