#include "pki/key_agreement.hpp"

#include <array>
#include <string_view>

#include <openssl/core_names.h>
#include <openssl/dh.h>

#include "base/hash.hpp"
#include "pki/openssl.hpp"

namespace ddssec::pki {

struct PeerPublicKey::Impl {
  PkeyPtr pkey;
};

namespace {

constexpr std::size_t kModpOctets = 256;
// The longest DER INTEGER of 256 octets of value: tag, three octets of length, a leading zero.
constexpr std::size_t kMostModpDerOctets = kModpOctets + 5;
constexpr std::size_t kMostSharedOctets = 256;

bool is_modp(KeyAgreementKind kind) { return kind == KeyAgreementKind::dh_modp_2048_256; }

std::size_t point_octets(KeyAgreementKind kind) {
  return kind == KeyAgreementKind::ecdh_p384 ? 97 : 65;
}

// RFC 5114 2.3 for MODP. Parameters are made once; keys copy them.
EVP_PKEY* parameters_for(KeyAgreementKind kind) {
  const auto make = [](const char* type, const char* group) {
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
  };
  static const std::array<PkeyPtr, 3> all = {make("EC", "P-256"), make("EC", "P-384"),
                                             make("DHX", "dh_2048_256")};
  return all[static_cast<std::size_t>(kind)].get();
}

Error not_in_group(const char* note) {
  take_openssl_reason();
  return Error(Code::public_key_not_in_group, {.note = note});
}

Error bad_form(std::string expected, std::string found) {
  return Error(Code::public_key_malformed,
               {.expected = std::move(expected), .found = std::move(found)});
}

Result<PkeyPtr> with_public(KeyAgreementKind kind, BytesView encoded) {
  PkeyPtr pkey(EVP_PKEY_new());
  EVP_PKEY* parameters = parameters_for(kind);
  if (!pkey || parameters == nullptr || EVP_PKEY_copy_parameters(pkey.get(), parameters) != 1)
    return openssl_failure(Code::internal);
  // OpenSSL checks here that a point is on the curve and not infinity.
  if (EVP_PKEY_set1_encoded_public_key(pkey.get(), encoded.data(), encoded.size()) != 1)
    return std::unexpected(not_in_group("it is not an element of the group"));
  return pkey;
}

Result<PkeyPtr> parse_point(KeyAgreementKind kind, BytesView octets) {
  constexpr std::uint8_t kUncompressed = 0x04;
  if (octets.size() == 1 && octets[0] == 0)
    return std::unexpected(not_in_group("it is the point at infinity"));
  if (octets.size() != point_octets(kind) || octets[0] != kUncompressed)
    return std::unexpected(
        bad_form("an uncompressed point of " + std::to_string(point_octets(kind)) + " octets",
                 std::to_string(octets.size()) + " octets"));
  return with_public(kind, octets);
}

// The value of a DER INTEGER that is positive, minimal and fills `octets` exactly.
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
        bad_form("an integer of 1 to 256 octets", std::to_string(value.size()) + " octets"));
  // DH keys are taken at the group's full length only.
  std::array<std::uint8_t, kModpOctets> padded{};
  std::copy(value.begin(), value.end(), padded.end() - static_cast<std::ptrdiff_t>(value.size()));
  PkeyPtr pkey = DDSSEC_TRY(with_public(KeyAgreementKind::dh_modp_2048_256, padded));
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_pkey(nullptr, pkey.get(), nullptr));
  // 1 < y < p - 1 and y^q = 1 mod p (SP 800-56A 5.6.2.3.1).
  if (!context || EVP_PKEY_public_check(context.get()) != 1)
    return std::unexpected(not_in_group("it is not in the subgroup of order q"));
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
  const OpensslMemory owner(raw);
  return size > 0 ? Bytes(raw, raw + size) : Bytes();
}

}  // namespace

Result<PeerPublicKey> PeerPublicKey::parse(KeyAgreementKind kind, BytesView octets) {
  const auto wrap = [&](PublicKeyEncoding encoding, PkeyPtr pkey) {
    return PeerPublicKey(kind, encoding, std::make_shared<const Impl>(std::move(pkey)));
  };
  if (!is_modp(kind)) return wrap(PublicKeyEncoding::point, DDSSEC_TRY(parse_point(kind, octets)));
  if (octets.size() > kMostModpDerOctets)
    return std::unexpected(bad_form("at most 261 octets", std::to_string(octets.size())));
  // Up to 256 octets, both readings are possible for one key in 2^24; the subgroup decides.
  if (const auto value = der_integer_value(octets)) {
    auto pkey = parse_modp(minimal(*value));
    if (pkey) return wrap(PublicKeyEncoding::der_integer, *std::move(pkey));
    if (octets.size() > kModpOctets) return std::unexpected(pkey.error());
  }
  return wrap(PublicKeyEncoding::plain_integer, DDSSEC_TRY(parse_modp(octets)));
}

Result<EphemeralKey> EphemeralKey::generate(KeyAgreementKind kind) {
  EVP_PKEY* parameters = parameters_for(kind);
  if (parameters == nullptr) return openssl_failure(Code::internal);
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_pkey(nullptr, parameters, nullptr));
  EVP_PKEY* raw = nullptr;
  if (!context || EVP_PKEY_keygen_init(context.get()) != 1 ||
      EVP_PKEY_generate(context.get(), &raw) != 1)
    return openssl_failure(Code::internal);
  return EphemeralKey(kind, std::make_shared<const Impl>(PkeyPtr(raw)));
}

Bytes EphemeralKey::public_octets(PublicKeyEncoding encoding) const {
  unsigned char* raw = nullptr;
  const std::size_t size = EVP_PKEY_get1_encoded_public_key(impl_->pkey.get(), &raw);
  const OpensslMemory owner(raw);
  const BytesView encoded(raw, size);
  if (!is_modp(kind_)) return to_bytes(encoded);
  return encoding == PublicKeyEncoding::der_integer ? der_integer(encoded) : minimal(encoded);
}

Result<SharedSecret> EphemeralKey::derive(const PeerPublicKey& peer) const {
  if (peer.kind() != kind_) return fail(Code::key_agreement_mismatch);
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_pkey(nullptr, impl_->pkey.get(), nullptr));
  // The peer's key was checked when it was parsed: no second check here.
  if (!context || EVP_PKEY_derive_init(context.get()) != 1 ||
      EVP_PKEY_derive_set_peer_ex(context.get(), peer.impl_->pkey.get(), 0) != 1)
    return openssl_failure(Code::internal);
  std::array<std::uint8_t, kMostSharedOctets> shared;
  std::size_t size = shared.size();
  const bool derived = EVP_PKEY_derive(context.get(), shared.data(), &size) == 1;
  auto secret = derived ? SharedSecret::copy_of(sha256(BytesView(shared.data(), size)))
                        : Result<SharedSecret>(openssl_failure(Code::internal));
  wipe(shared);
  return secret;
}

Result<SharedSecret> EphemeralKey::derive(BytesView peer_octets) const {
  return derive(DDSSEC_TRY(PeerPublicKey::parse(kind_, peer_octets)));
}

}  // namespace ddssec::pki
