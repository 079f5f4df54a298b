#include "pki/private_key.hpp"

#include <array>

#include <fmt/format.h>

#include "base/hash.hpp"
#include "base/rollback.hpp"
#include "pki/key_derivation.hpp"
#include "pki/openssl.hpp"
#include "pki/pem_block.hpp"
#include "pki/pkcs11.hpp"
#include "pki/pki_access.hpp"
#include "pki/signature.hpp"

namespace ddssec::pki {
namespace {

struct PassphraseRequest {
  const Passphrase* passphrase;
  bool asked = false;
};

int give_passphrase(char* out, int room, int /*writing*/, void* user) {
  auto& request = *static_cast<PassphraseRequest*>(user);
  request.asked = true;
  if (request.passphrase == nullptr) return -1;
  return request.passphrase->expose([&](BytesView octets) {
    if (octets.size() > static_cast<std::size_t>(room)) return -1;
    std::copy(octets.begin(), octets.end(), out);
    return static_cast<int>(octets.size());
  });
}

// Overwrites what functions called earlier from the same place have left on the stack. OpenSSL's
// readers of encrypted keys (3.0: epki2pki) leave the passphrase there.
[[gnu::noinline]] void wipe_stack() {
  std::array<std::uint8_t, std::size_t{32} << 10> room;
  wipe(room);
}

Result<PrivateKey> finish(PkeyPtr pkey) {
  DDSSEC_ASSIGN_OR_RETURN(const auto algorithm, judge_key(pkey.get()));
  return PkiAccess::make<PrivateKey>(
      std::make_shared<PkiAccess::PrivateKeyImpl>(std::move(pkey), algorithm));
}

// An engine's key does not report its curve, so its public half is encoded and decoded, and that
// key is judged.
Result<KeyAlgorithm> judge_token_key(EVP_PKEY* key) {
  unsigned char* der = nullptr;
  const int size = i2d_PUBKEY(key, &der);
  const OpensslMemoryPtr owner(der);
  const unsigned char* at = der;
  const PkeyPtr half(size > 0 ? d2i_PUBKEY(nullptr, &at, size) : nullptr);
  return judge_key(half.get(), "a token");
}

Result<PrivateKey> from_token(std::string_view uri, const Passphrase* pin) {
  DDSSEC_ASSIGN_OR_RETURN(auto pkey, token_private_key(uri, pin));
  DDSSEC_ASSIGN_OR_RETURN(const auto algorithm, judge_token_key(pkey.get()));
  return PkiAccess::make<PrivateKey>(
      std::make_shared<PkiAccess::PrivateKeyImpl>(std::move(pkey), algorithm, KeyPlace::token));
}

Result<PrivateKey> from_uri(std::string_view uri, const Passphrase* passphrase) {
  if (names_token(uri)) return from_token(uri, passphrase);
  DDSSEC_ASSIGN_OR_RETURN(const auto pem, load_secret<KeyPem>(uri, ""));
  return PrivateKey::from_pem(pem, passphrase);
}

BytesView self_test_message() { return as_bytes("ddssec: does this key fit this certificate?"); }

// OpenSSL's reason says where the decrypted octets made no sense ("pkcs12 cipherfinal error"),
// which does not help. Another cause is only an algorithm that OpenSSL does not support.
std::unexpected<Error> passphrase_error(Code code) {
  auto failure = openssl_error(code);
  const auto& error = failure.error();
  if (error.code() != code || error.details().note.contains("unsupported")) return failure;
  return fail(code);
}

}  // namespace

Result<PrivateKey> PrivateKey::from_pem(BytesView pem, const Passphrase* passphrase) {
  if (pem.size() > KeyPem::capacity)
    return fail(Code::private_key_malformed, {.note = "it is too long for a key"});
  if (passphrase != nullptr) DDSSEC_RETURN_IF_ERROR(check_key_derivation(pem));
  const BioPtr bio = bio_over(pem);
  PassphraseRequest request{passphrase};
  PkeyPtr pkey(PEM_read_bio_PrivateKey(bio.get(), nullptr, give_passphrase, &request));
  if (request.asked) wipe_stack();
  if (pkey) {
    take_openssl_reason();
    return finish(std::move(pkey));
  }
  if (request.asked)
    return passphrase_error(passphrase == nullptr ? Code::passphrase_missing
                                                  : Code::passphrase_wrong);
  if (!is_der(pem)) return openssl_error(Code::private_key_malformed);
  take_openssl_reason();
  return fail(Code::private_key_malformed,
              {.expected = "PEM",
               .found = "DER",
               .hint = "write it as PEM: openssl pkey -inform DER -in FILE -out FILE.pem"});
}

Result<PrivateKey> PrivateKey::from_pem(const KeyPem& pem, const Passphrase* passphrase) {
  return pem.expose([&](BytesView octets) { return from_pem(octets, passphrase); });
}

Result<PrivateKey> PrivateKey::load(std::string_view uri, std::string_view property,
                                    const Passphrase* passphrase) {
  return with_default_document(from_uri(uri, passphrase), std::string(property));
}

Result<PrivateKey> PrivateKey::generate(KeyKind kind, int bits) {
  const char* group = kind == KeyKind::ec_p384 ? "P-384" : "P-256";
  if (kind == KeyKind::rsa && (bits < kMinRsaBits || bits > kMaxRsaBits))
    return fail(Code::key_not_allowed,
                {.expected = fmt::format("RSA of {} to {} bits", kMinRsaBits, kMaxRsaBits),
                 .found = fmt::format("RSA of {} bits", bits)});
  PkeyPtr pkey(kind == KeyKind::rsa
                   ? EVP_PKEY_Q_keygen(nullptr, nullptr, "RSA", static_cast<std::size_t>(bits))
                   : EVP_PKEY_Q_keygen(nullptr, nullptr, "EC", group));
  if (!pkey) return openssl_error(Code::internal);
  return finish(std::move(pkey));
}

Result<KeyPem> PrivateKey::to_pem(const Passphrase* passphrase) const {
  if (in_token()) return fail(Code::key_in_token);
  // The secure-memory BIO wipes its buffer when it is freed.
  const BioPtr bio(BIO_new(BIO_s_secmem()));
  PassphraseRequest request{passphrase};
  const Rollback wipe_at_end([&] {
    if (request.asked) wipe_stack();
  });
  const EVP_CIPHER* cipher = passphrase != nullptr ? EVP_aes_256_cbc() : nullptr;
  if (!bio || PEM_write_bio_PKCS8PrivateKey(bio.get(), impl_->pkey.get(), cipher, nullptr, 0,
                                            give_passphrase, &request) != 1)
    return openssl_error(Code::internal);
  return KeyPem::copy_of(bio_octets(bio));
}

KeyAlgorithm PrivateKey::algorithm() const { return impl_->algorithm; }

bool PrivateKey::in_token() const { return impl_->place == KeyPlace::token; }

Status PrivateKey::check_fits(const Certificate& certificate) const {
  const ErrorDetails details{.field = "private key for " + certificate.subject(),
                             .expected = to_string(certificate.key_algorithm()),
                             .found = to_string(algorithm()) + " of another pair"};
  EVP_PKEY* expected = X509_get0_pubkey(impl_of(certificate).x509.get());
  if (EVP_PKEY_eq(impl_->pkey.get(), expected) != 1)
    return openssl_error(Code::key_mismatch, details);
  // A key file may contain the right public half with a wrong private half.
  const auto signature = sign(*this, self_test_message());
  if (!signature || !verify(certificate, self_test_message(), *signature))
    return fail(Code::key_mismatch, details);
  return {};
}

}  // namespace ddssec::pki
