#include "pki/key_agreement.hpp"

#include <array>
#include <mutex>
#include <utility>

#include <openssl/core_names.h>
#include <openssl/ec.h>
#include <openssl/param_build.h>

#include "base/hash.hpp"
#include "base/never_destroyed.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {

namespace {

constexpr std::size_t kModpOctets = 256;
// The longest DER INTEGER with a value of 256 octets: tag, three octets of length, a leading zero.
constexpr std::size_t kMaxModpDerOctets = kModpOctets + 5;
constexpr std::size_t kMaxSharedOctets = 256;

bool is_modp(KeyAgreementKind kind) { return kind == KeyAgreementKind::dh_modp_2048_256; }

std::size_t point_octets(KeyAgreementKind kind) {
  return kind == KeyAgreementKind::ecdh_p384 ? 97 : 65;
}

// Makes the parameters of a group, for MODP those of RFC 5114 2.3. Returns nullptr if there is no
// memory.
PkeyPtr make_parameters(KeyAgreementKind kind) {
  constexpr std::array<std::pair<const char*, const char*>, 3> kGroups{
      {{"EC", "P-256"}, {"EC", "P-384"}, {"DHX", "dh_2048_256"}}};
  const auto& [type, group] = kGroups.at(static_cast<std::size_t>(kind));
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_name(nullptr, type, nullptr));
  std::string name(group);
  const OSSL_PARAM list[] = {
      OSSL_PARAM_construct_utf8_string(OSSL_PKEY_PARAM_GROUP_NAME, name.data(), 0),
      OSSL_PARAM_construct_end()};
  EVP_PKEY* out = nullptr;
  if (!context || EVP_PKEY_fromdata_init(context.get()) != 1 ||
      EVP_PKEY_fromdata(context.get(), &out, EVP_PKEY_KEY_PARAMETERS,
                        const_cast<OSSL_PARAM*>(list)) != 1)
    take_openssl_reason();
  return PkeyPtr(out);
}

// Returns parameters that are created once; keys copy them. After a failure, the next call tries
// again.
EVP_PKEY* parameters_for(KeyAgreementKind kind) {
  static std::mutex mutex;
  static NeverDestroyed<std::array<PkeyPtr, 3>> made;
  const std::lock_guard lock(mutex);
  auto& parameters = made->at(static_cast<std::size_t>(kind));
  if (!parameters) parameters = make_parameters(kind);
  return parameters.get();
}

Error not_in_group_error(const char* note) {
  take_openssl_reason();
  return Error(Code::public_key_not_in_group, {.note = note});
}

Error bad_form_error(std::string expected, std::string found) {
  return Error(Code::public_key_malformed,
               {.expected = std::move(expected), .found = std::move(found)});
}

Result<PkeyPtr> with_public(KeyAgreementKind kind, BytesView encoded) {
  PkeyPtr pkey(EVP_PKEY_new());
  EVP_PKEY* parameters = parameters_for(kind);
  if (!pkey || parameters == nullptr || EVP_PKEY_copy_parameters(pkey.get(), parameters) != 1)
    return openssl_error(Code::internal);
  // OpenSSL checks here that a point is on the curve and not infinity.
  if (EVP_PKEY_set1_encoded_public_key(pkey.get(), encoded.data(), encoded.size()) != 1)
    return std::unexpected(not_in_group_error("it is not an element of the group"));
  return pkey;
}

Result<PkeyPtr> parse_point(KeyAgreementKind kind, BytesView octets) {
  constexpr std::uint8_t kUncompressed = 0x04;
  if (octets.size() == 1 && octets[0] == 0)
    return std::unexpected(not_in_group_error("it is the point at infinity"));
  if (octets.size() != point_octets(kind) || octets[0] != kUncompressed)
    return std::unexpected(
        bad_form_error("an uncompressed point of " + std::to_string(point_octets(kind)) + " octets",
                       std::to_string(octets.size()) + " octets"));
  return with_public(kind, octets);
}

// Returns the value of a DER INTEGER that is positive, minimal and fills `octets` exactly.
std::optional<Bytes> der_integer_value(BytesView octets) {
  const auto* position = octets.data();
  const Asn1IntegerPtr integer(
      d2i_ASN1_INTEGER(nullptr, &position, static_cast<long>(octets.size())));
  const bool exact = integer && position == octets.data() + octets.size() &&
                     ASN1_STRING_type(integer.get()) == V_ASN1_INTEGER;
  if (!exact) {
    take_openssl_reason();
    return std::nullopt;
  }
  return to_bytes({ASN1_STRING_get0_data(integer.get()),
                   static_cast<std::size_t>(ASN1_STRING_length(integer.get()))});
}

Result<PkeyPtr> parse_modp(BytesView value) {
  if (value.empty() || value.size() > kModpOctets)
    return std::unexpected(
        bad_form_error("an integer of 1 to 256 octets", std::to_string(value.size()) + " octets"));
  // OpenSSL accepts DH keys only at the group's full length.
  std::array<std::uint8_t, kModpOctets> padded{};
  std::copy(value.begin(), value.end(), padded.end() - static_cast<std::ptrdiff_t>(value.size()));
  DDSSEC_ASSIGN_OR_RETURN(PkeyPtr pkey, with_public(KeyAgreementKind::dh_modp_2048_256, padded));
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_pkey(nullptr, pkey.get(), nullptr));
  // Checks that 1 < y < p - 1 and y^q = 1 mod p (SP 800-56A 5.6.2.3.1).
  if (!context || EVP_PKEY_public_check(context.get()) != 1)
    return std::unexpected(not_in_group_error("it is not in the subgroup of order q"));
  return pkey;
}

Bytes minimal(BytesView integer) {
  std::size_t zeros = 0;
  while (zeros + 1 < integer.size() && integer[zeros] == 0) ++zeros;
  return to_bytes(integer.subspan(zeros));
}

Bytes der_integer(BytesView value) {
  const BignumPtr number(BN_bin2bn(value.data(), static_cast<int>(value.size()), nullptr));
  const Asn1IntegerPtr integer(number ? BN_to_ASN1_INTEGER(number.get(), nullptr) : nullptr);
  unsigned char* raw = nullptr;
  const int size = integer ? i2d_ASN1_INTEGER(integer.get(), &raw) : -1;
  const OpensslMemoryPtr owner(raw);
  return size > 0 ? Bytes(raw, raw + size) : Bytes();
}

}  // namespace

Result<PeerPublicKey> PeerPublicKey::parse(KeyAgreementKind kind, BytesView octets) {
  const auto wrap = [&](PublicKeyEncoding encoding, PkeyPtr pkey) {
    return PeerPublicKey(kind, encoding, std::make_shared<const Impl>(std::move(pkey)));
  };
  if (!is_modp(kind)) {
    DDSSEC_ASSIGN_OR_RETURN(auto point, parse_point(kind, octets));
    return wrap(PublicKeyEncoding::point, std::move(point));
  }
  if (octets.size() > kMaxModpDerOctets)
    return std::unexpected(bad_form_error("at most 261 octets", std::to_string(octets.size())));
  // For up to 256 octets, one key in 2^24 can be read in both encodings; the check of the subgroup
  // decides.
  if (const auto value = der_integer_value(octets)) {
    auto pkey = parse_modp(minimal(*value));
    if (pkey) return wrap(PublicKeyEncoding::der_integer, *std::move(pkey));
    if (octets.size() > kModpOctets) return std::unexpected(pkey.error());
  }
  DDSSEC_ASSIGN_OR_RETURN(auto modp, parse_modp(octets));
  return wrap(PublicKeyEncoding::plain_integer, std::move(modp));
}

Result<EphemeralKey> EphemeralKey::generate(KeyAgreementKind kind) {
  EVP_PKEY* parameters = parameters_for(kind);
  if (parameters == nullptr) return openssl_error(Code::internal);
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_pkey(nullptr, parameters, nullptr));
  EVP_PKEY* raw = nullptr;
  if (!context || EVP_PKEY_keygen_init(context.get()) != 1 ||
      EVP_PKEY_generate(context.get(), &raw) != 1)
    return openssl_error(Code::internal);
  return EphemeralKey(kind, std::make_shared<const Impl>(PkeyPtr(raw)));
}

Result<Bytes> EphemeralKey::public_octets(PublicKeyEncoding encoding) const {
  unsigned char* raw = nullptr;
  const std::size_t size = EVP_PKEY_get1_encoded_public_key(impl_->pkey.get(), &raw);
  const OpensslMemoryPtr owner(raw);
  if (size == 0) return fail(Code::internal, {.note = "the public key cannot be written"});
  const BytesView encoded(raw, size);
  if (!is_modp(kind_)) return to_bytes(encoded);
  return encoding == PublicKeyEncoding::der_integer ? der_integer(encoded) : minimal(encoded);
}

Result<AgreedSecret> EphemeralKey::derive(const PeerPublicKey& peer) const {
  if (peer.kind() != kind_) return fail(Code::key_agreement_mismatch);
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_pkey(nullptr, impl_->pkey.get(), nullptr));
  // The peer's key was checked when it was parsed, so it is not checked again here.
  if (!context || EVP_PKEY_derive_init(context.get()) != 1 ||
      EVP_PKEY_derive_set_peer_ex(context.get(), peer.impl_->pkey.get(), 0) != 1)
    return openssl_error(Code::internal);
  std::array<std::uint8_t, kMaxSharedOctets> shared;
  std::size_t size = shared.size();
  const bool derived =
      EVP_PKEY_derive(context.get(), shared.data(), &size) == 1 && size <= shared.size();
  auto secret = derived ? AgreedSecret::digest_of(BytesView(shared.data(), size))
                        : Result<AgreedSecret>(openssl_error(Code::internal));
  wipe(shared);
  return secret;
}

Result<AgreedSecret> EphemeralKey::derive(BytesView peer_octets) const {
  DDSSEC_ASSIGN_OR_RETURN(const auto peer_public_key, PeerPublicKey::parse(kind_, peer_octets));
  return derive(peer_public_key);
}

}  // namespace ddssec::pki
