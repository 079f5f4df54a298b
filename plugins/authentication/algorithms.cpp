#include "plugins/authentication/algorithms.hpp"

#include <algorithm>
#include <array>

namespace ddssec::authentication {
namespace {

using pki::KeyAgreementKind;

constexpr std::string_view kRsaPss = "RSASSA-PSS-SHA256";
constexpr std::string_view kEcdsaP256 = "ECDSA-SHA256";
constexpr std::string_view kEcdsaP384 = "ECDSA+P384+SHA384";

constexpr std::array kSignatureNames = {kRsaPss, kEcdsaP256, kEcdsaP384,
                                        // DDS-Security 1.2
                                        std::string_view("RSASSA-PSS-MGF1SHA256+2048+SHA256"),
                                        std::string_view("ECDSA+P256+SHA256")};

struct KeyAgreementName {
  KeyAgreementKind kind;
  std::string_view name;
};

// The first name of each kind is the one to send.
constexpr std::array kKeyAgreementNames = {
    KeyAgreementName{KeyAgreementKind::ecdh_p256, "ECDH+prime256v1-CEUM"},
    KeyAgreementName{KeyAgreementKind::ecdh_p256, "ECDHE-CEUM+P256"},
    KeyAgreementName{KeyAgreementKind::ecdh_p256, "ECDH+prime256v1"},
    KeyAgreementName{KeyAgreementKind::ecdh_p384, "ECDHE-CEUM+P384"},
    KeyAgreementName{KeyAgreementKind::dh_modp_2048_256, "DH+MODP-2048-256"},
    KeyAgreementName{KeyAgreementKind::dh_modp_2048_256, "DHE+MODP-2048-256"},
};

}  // namespace

std::string_view algorithm_text(BytesView octets) {
  std::string_view text = as_text(octets);
  if (text.ends_with('\0')) text.remove_suffix(1);
  return text;
}

std::string_view signature_algorithm_name(pki::KeyAlgorithm key) {
  switch (key.kind) {
    case pki::KeyKind::rsa:
      return kRsaPss;
    case pki::KeyKind::ec_p256:
      return kEcdsaP256;
    case pki::KeyKind::ec_p384:
      return kEcdsaP384;
  }
  return {};
}

bool is_signature_algorithm(std::string_view name) {
  return std::ranges::find(kSignatureNames, name) != kSignatureNames.end();
}

std::string_view key_agreement_name(KeyAgreementKind kind) {
  return std::ranges::find(kKeyAgreementNames, kind, &KeyAgreementName::kind)->name;
}

std::optional<KeyAgreementKind> key_agreement_kind_from(std::string_view name) {
  const auto row = std::ranges::find(kKeyAgreementNames, name, &KeyAgreementName::name);
  if (row == kKeyAgreementNames.end()) return std::nullopt;
  return row->kind;
}

}  // namespace ddssec::authentication
