#include "cli/inputs/keys.hpp"

#include "base/uri_source.hpp"
#include "cli/frame/held_folder.hpp"
#include "cli/inputs/files.hpp"
#include "cli/inputs/passphrase.hpp"
#include "pki/certificate_source.hpp"

namespace ddssec::cli {

namespace fs = std::filesystem;

Result<bool> is_encrypted(const fs::path& key) {
  const auto pem = load_secret<pki::KeyPem>("file://" + path_in_held_folder(key).string(), "");
  if (!pem) return file_error(pem.error(), key);
  return pem->expose([](BytesView octets) {
    const auto text = as_text(octets);
    return text.find("BEGIN ENCRYPTED") != text.npos || text.find(",ENCRYPTED") != text.npos;
  });
}

Result<pki::PrivateKey> read_key(const fs::path& path, const pki::Passphrase* passphrase) {
  const auto uri = pki::uri_of(path_in_held_folder(path));
  if (!uri) return file_error(uri.error(), path);
  auto key = pki::PrivateKey::load(*uri, "", passphrase);
  if (!key) return file_error(key.error(), path);
  return key;
}

Result<pki::KeySpec> key_spec_of(std::string_view key, std::string_view field) {
  if (key == "p256") return pki::KeySpec{};
  if (key == "rsa2048") return pki::KeySpec{pki::KeyKind::rsa, 2048};
  if (key == "rsa3072") return pki::KeySpec{pki::KeyKind::rsa, 3072};
  return fail(Code::usage, {.field = std::string(field),
                            .expected = "p256, rsa2048 or rsa3072",
                            .found = std::string(key)});
}

Result<pki::KeySpec> key_spec(const Arguments& arguments) {
  return key_spec_of(arguments.text("--key"), "--key");
}

Result<pki::PrivateKey> token_key(const std::string& uri, const Arguments& arguments) {
  const bool names_pin = uri.contains("pin-source=") || uri.contains("pin-value=");
  if (names_pin) return pki::PrivateKey::load(uri, "");
  DDSSEC_ASSIGN_OR_RETURN(const auto pin, passphrase(arguments, "PIN of the token: "));
  return pki::PrivateKey::load(uri, "", &pin);
}

Result<NewKey> new_key(const Arguments& arguments) {
  const auto wanted = arguments.text("--key");
  if (names_token(wanted)) {
    DDSSEC_ASSIGN_OR_RETURN(auto private_key, token_key(wanted, arguments));
    return NewKey{std::move(private_key), wanted};
  }
  DDSSEC_ASSIGN_OR_RETURN(const auto spec, key_spec(arguments));
  DDSSEC_ASSIGN_OR_RETURN(auto private_key, pki::PrivateKey::generate(spec.kind, spec.bits));
  return NewKey{std::move(private_key), {}};
}

}  // namespace ddssec::cli
