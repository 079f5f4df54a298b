#include "pki/signing_time.hpp"

#include "pki/openssl.hpp"

namespace ddssec::pki {

std::optional<WallTime> signing_time_of(const CMS_SignerInfo* signer) {
  const int place = CMS_signed_get_attr_by_NID(signer, NID_pkcs9_signingTime, -1);
  if (place < 0 || CMS_signed_get_attr_by_NID(signer, NID_pkcs9_signingTime, place) >= 0)
    return std::nullopt;
  X509_ATTRIBUTE* const attribute = CMS_signed_get_attr(signer, place);
  if (X509_ATTRIBUTE_count(attribute) != 1) return std::nullopt;
  const ASN1_TYPE* const value = X509_ATTRIBUTE_get0_type(attribute, 0);
  const int type = value != nullptr ? ASN1_TYPE_get(value) : V_ASN1_UNDEF;
  if (type != V_ASN1_UTCTIME && type != V_ASN1_GENERALIZEDTIME) return std::nullopt;
  const auto time = to_wall_time(value->value.asn1_string);
  return time ? std::optional(*time) : std::nullopt;
}

}  // namespace ddssec::pki
