#include "plugins/access_control/allowed_algorithms.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

namespace ddssec::access_control {
namespace {

using governance::AllowedAlgorithms;
using List = std::vector<governance::Text>;

// The longest chain to follow, longer than any chain that is verified.
constexpr int kMaxAuthorities = 16;

// Returns the names that allow a key: those of DDS-Security 1.2, clause 8.2 first, then those of
// 1.1.
std::vector<std::string> names_of(pki::KeyAlgorithm key) {
  switch (key.kind) {
    case pki::KeyKind::ec_p256:
      return {"ECDSA+P256+SHA256", "EC-prime256v1", "ECDSA-SHA256"};
    case pki::KeyKind::ec_p384:
      return {"ECDSA+P384+SHA384", "EC-secp384r1"};
    case pki::KeyKind::rsa:
      break;
  }
  const auto bits = std::to_string(key.bits);
  std::vector<std::string> names = {"RSASSA-PSS-MGF1SHA256+" + bits + "+SHA256",
                                    "RSASSA-PKCS1-V1_5+" + bits + "+SHA256", "RSA-" + bits};
  if (key.bits == 2048) names.emplace_back("RSASSA-PSS-SHA256");
  return names;
}

constexpr std::array kP256 = {std::string_view("ECDHE-CEUM+P256"),
                              std::string_view("ECDH+prime256v1-CEUM"),
                              std::string_view("ECDH+prime256v1")};
constexpr std::array kP384 = {std::string_view("ECDHE-CEUM+P384")};
constexpr std::array kModp = {std::string_view("DHE+MODP-2048-256"),
                              std::string_view("DH+MODP-2048-256")};

bool is_listed(const List& list, std::string_view name) {
  return std::ranges::any_of(list, [&](const auto& text) { return text.text == name; });
}
bool lists_any(const List& list, const auto& names) {
  return std::ranges::any_of(names, [&](const auto& name) { return is_listed(list, name); });
}

std::string text_of(const List& list) {
  std::string out;
  for (const auto& one : list) out += (out.empty() ? "" : ", ") + one.text;
  return out.empty() ? "none" : out;
}

// Returns the list for trust chains; if there is none, the list for identities (DDS-Security 1.2,
// clause 10.4.1.2.5.9.2).
const List& trust_chain_list(const AllowedAlgorithms& allowed) {
  const auto& own = allowed.digital_signature_identity_trust_chain;
  return own.empty() ? allowed.digital_signature : own;
}
std::string trust_chain_element(const AllowedAlgorithms& allowed) {
  return allowed.digital_signature_identity_trust_chain.empty()
             ? "<digital_signature>, which also counts for certificate authorities"
             : "<digital_signature_identity_trust_chain>";
}

Status check_key(Code code, const List& list, int line, std::string element,
                 const pki::Certificate& certificate) {
  const auto names = names_of(certificate.key_algorithm());
  if (lists_any(list, names)) return {};
  return fail(code, {.line = line,
                     .field = std::move(element),
                     .expected = text_of(list),
                     .found = names.front() + " of " + certificate.subject()});
}

}  // namespace

Status check_authority(const AllowedAlgorithms& allowed, const pki::Certificate& authority) {
  return check_key(Code::trust_chain_algorithm_not_allowed, trust_chain_list(allowed), allowed.line,
                   trust_chain_element(allowed), authority);
}

Status check_identity(const AllowedAlgorithms& allowed, const pki::Certificate& certificate,
                      std::span<const pki::Certificate> authorities) {
  DDSSEC_RETURN_IF_ERROR(check_key(Code::identity_algorithm_not_allowed, allowed.digital_signature,
                                   allowed.line, "<digital_signature>", certificate));
  const auto* below = &certificate;
  for (int i = 0; i < kMaxAuthorities; ++i) {
    const auto issuer = std::ranges::find_if(
        authorities, [&](const auto& authority) { return below->is_issued_by(authority); });
    if (issuer == authorities.end()) {
      if (i > 0) return {};  // the file ends with a subordinate CA
      return fail(Code::trust_chain_algorithm_not_allowed,
                  {.line = allowed.line,
                   .field = trust_chain_element(allowed),
                   .expected = text_of(trust_chain_list(allowed)),
                   .found = "unknown: the issuer is not in identity_ca",
                   .note = certificate.issuer()});
    }
    DDSSEC_RETURN_IF_ERROR(check_authority(allowed, *issuer));
    if (issuer->is_self_issued()) return {};
    below = &*issuer;
  }
  return {};
}

Status check_key_establishment(const AllowedAlgorithms& allowed,
                               std::optional<std::string_view> used) {
  const auto& list = allowed.key_establishment;
  const auto of_kind = [&](const auto& names) {
    return std::ranges::find(names, *used) != names.end() && lists_any(list, names);
  };
  const bool allows = used ? of_kind(kP256) || of_kind(kP384) || of_kind(kModp)
                           : lists_any(list, kP256) && lists_any(list, kModp);
  if (allows) return {};
  return fail(Code::key_establishment_not_allowed,
              {.line = allowed.line,
               .field = "<key_establishment>",
               .expected = text_of(list),
               .found = used ? std::string(used->substr(0, 64))
                             : "unknown: the authentication plugin does not say"});
}

}  // namespace ddssec::access_control
