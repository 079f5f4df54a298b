#include "tests/support/known_key.hpp"

#include <array>
#include <memory>
#include <string>

#include <openssl/bn.h>
#include <openssl/core_names.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/param_build.h>

#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

// Returns the point `number` times the generator, or nothing if `number` is out of range.
Bytes public_point(int curve, const BIGNUM* number) {
  const GroupPtr group(EC_GROUP_new_by_curve_name(curve));
  const PointPtr point(group ? EC_POINT_new(group.get()) : nullptr);
  if (!point || BN_cmp(number, EC_GROUP_get0_order(group.get())) >= 0 ||
      EC_POINT_mul(group.get(), point.get(), number, nullptr, nullptr, nullptr) != 1)
    return {};
  Bytes out(EC_POINT_point2oct(group.get(), point.get(), POINT_CONVERSION_UNCOMPRESSED, nullptr, 0,
                               nullptr));
  EC_POINT_point2oct(group.get(), point.get(), POINT_CONVERSION_UNCOMPRESSED, out.data(),
                     out.size(), nullptr);
  return out.size() > 1 ? out : Bytes();
}

// Returns a parameter of the group of RFC 5114 2.3.
BignumPtr modp_parameter(const char* name) {
  const PkeyContextPtr context(EVP_PKEY_CTX_new_from_name(nullptr, "DHX", nullptr));
  std::string group = "dh_2048_256";
  OSSL_PARAM list[] = {
      OSSL_PARAM_construct_utf8_string(OSSL_PKEY_PARAM_GROUP_NAME, group.data(), 0),
      OSSL_PARAM_construct_end()};
  EVP_PKEY* raw = nullptr;
  if (!context || EVP_PKEY_fromdata_init(context.get()) != 1 ||
      EVP_PKEY_fromdata(context.get(), &raw, EVP_PKEY_KEY_PARAMETERS, list) != 1)
    return nullptr;
  const PkeyPtr parameters(raw);
  BIGNUM* value = nullptr;
  EVP_PKEY_get_bn_param(parameters.get(), name, &value);
  return BignumPtr(value);
}

// Returns g to the power of `number`, at the group's length, or nothing if `number` is out of
// range.
Bytes public_element(const BIGNUM* number) {
  const auto p = modp_parameter(OSSL_PKEY_PARAM_FFC_P);
  const auto q = modp_parameter(OSSL_PKEY_PARAM_FFC_Q);
  const auto g = modp_parameter(OSSL_PKEY_PARAM_FFC_G);
  const BignumContextPtr context(BN_CTX_new());
  const BignumPtr out(BN_new());
  if (!p || !q || !g || !context || !out || BN_is_zero(number) || BN_cmp(number, q.get()) >= 0 ||
      BN_mod_exp(out.get(), g.get(), number, p.get(), context.get()) != 1)
    return {};
  Bytes octets(256);
  return BN_bn2binpad(out.get(), octets.data(), static_cast<int>(octets.size())) > 0 ? octets
                                                                                     : Bytes();
}

Bytes public_of(KeyAgreementKind kind, const BIGNUM* number) {
  if (kind == KeyAgreementKind::dh_modp_2048_256) return public_element(number);
  return public_point(kind == KeyAgreementKind::ecdh_p384 ? NID_secp384r1 : NID_X9_62_prime256v1,
                      number);
}

Result<PkeyPtr> make_pair(KeyAgreementKind kind, const BIGNUM* number, BytesView element) {
  const bool is_modp = kind == KeyAgreementKind::dh_modp_2048_256;
  constexpr std::array kGroups = {"P-256", "P-384", "dh_2048_256"};
  const ParameterBuilderPtr builder(OSSL_PARAM_BLD_new());
  const BignumPtr y(BN_bin2bn(element.data(), static_cast<int>(element.size()), nullptr));
  const char* group = kGroups.at(static_cast<std::size_t>(kind));
  const bool built =
      builder && y &&
      OSSL_PARAM_BLD_push_utf8_string(builder.get(), OSSL_PKEY_PARAM_GROUP_NAME, group, 0) == 1 &&
      OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_PRIV_KEY, number) == 1 &&
      (is_modp ? OSSL_PARAM_BLD_push_BN(builder.get(), OSSL_PKEY_PARAM_PUB_KEY, y.get())
               : OSSL_PARAM_BLD_push_octet_string(builder.get(), OSSL_PKEY_PARAM_PUB_KEY,
                                                  element.data(), element.size())) == 1;
  const ParametersPtr parameters(built ? OSSL_PARAM_BLD_to_param(builder.get()) : nullptr);
  const PkeyContextPtr context(
      EVP_PKEY_CTX_new_from_name(nullptr, is_modp ? "DHX" : "EC", nullptr));
  EVP_PKEY* out = nullptr;
  if (!parameters || !context || EVP_PKEY_fromdata_init(context.get()) != 1 ||
      EVP_PKEY_fromdata(context.get(), &out, EVP_PKEY_KEYPAIR, parameters.get()) != 1)
    return fail(Code::internal);
  return PkeyPtr(out);
}

}  // namespace

Result<EphemeralKey> KnownKey::from_private(KeyAgreementKind kind, BytesView number) {
  const SecretBignumPtr secret(
      BN_bin2bn(number.data(), static_cast<int>(number.size()), BN_secure_new()));
  const auto element = secret ? public_of(kind, secret.get()) : Bytes();
  if (element.empty())
    return fail(Code::public_key_not_in_group, {.note = "the private number is out of range"});
  DDSSEC_ASSIGN_OR_RETURN(auto pair, make_pair(kind, secret.get(), element));
  return EphemeralKey(kind, std::make_shared<const EphemeralKey::Impl>(std::move(pair)));
}

}  // namespace ddssec::pki
