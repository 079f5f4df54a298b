#include "pki/openssl.hpp"

#include <climits>

#include <openssl/core_names.h>
#include <openssl/err.h>

namespace ddssec::pki {

std::string take_openssl_reason() {
  const unsigned long error = ERR_peek_last_error();
  ERR_clear_error();
  const char* reason = ERR_reason_error_string(error);
  return reason != nullptr ? reason : "";
}

std::unexpected<Error> openssl_error(Code code, ErrorDetails details) {
  const bool wanted_memory = ERR_GET_REASON(ERR_peek_last_error()) == ERR_R_MALLOC_FAILURE;
  auto reason = take_openssl_reason();
  if (wanted_memory) return fail(Code::out_of_memory);  // the document itself may be good
  if (details.note.empty()) details.note = std::move(reason);
  return fail(code, std::move(details));
}

BioPtr bio_over(BytesView octets) {
  if (octets.size() > INT_MAX) return nullptr;
  return BioPtr(BIO_new_mem_buf(octets.data(), static_cast<int>(octets.size())));
}

BytesView bio_octets(const BioPtr& bio) {
  char* data = nullptr;
  const long size = BIO_get_mem_data(bio.get(), &data);
  return as_bytes({data, static_cast<std::size_t>(size)});
}

Result<WallTime> to_wall_time(const ASN1_TIME* time) {
  std::tm parts{};
  if (time == nullptr || ASN1_TIME_to_tm(time, &parts) != 1)
    return openssl_error(Code::malformed, {.field = "time"});
  using namespace std::chrono;
  const sys_days day = year(parts.tm_year + 1900) / month(static_cast<unsigned>(parts.tm_mon + 1)) /
                       std::chrono::day(static_cast<unsigned>(parts.tm_mday));
  return WallTime(day + hours(parts.tm_hour) + minutes(parts.tm_min) + seconds(parts.tm_sec));
}

Result<Asn1TimePtr> to_asn1_time(WallTime time) {
  Asn1TimePtr out(ASN1_TIME_set(nullptr, to_time_t(time)));
  if (!out) return openssl_error(Code::internal);
  return out;
}

std::string name_rfc2253(const X509_NAME* name) {
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (!bio || X509_NAME_print_ex(bio.get(), name, 0, XN_FLAG_RFC2253) < 0) return {};
  return std::string(as_text(bio_octets(bio)));
}

std::optional<std::string> to_utf8(const ASN1_STRING* value) {
  unsigned char* raw = nullptr;
  const int size = ASN1_STRING_to_UTF8(&raw, value);
  const OpensslMemoryPtr owner(raw);
  if (size < 0) {
    take_openssl_reason();
    return std::nullopt;
  }
  std::string text(as_text({raw, static_cast<std::size_t>(size)}));
  if (text.find('\0') != text.npos) return std::nullopt;
  return text;
}

namespace {

// Returns the curve's name, or "" if the key spells out parameters of its own (CVE-2020-0601).
std::string group_name(EVP_PKEY* key) {
  char name[64];
  std::size_t size = 0;
  const bool named = EVP_PKEY_get_utf8_string_param(key, OSSL_PKEY_PARAM_EC_ENCODING, name,
                                                    sizeof name, nullptr) == 1 &&
                     std::string_view(name) == OSSL_PKEY_EC_ENCODING_GROUP;
  if (!named) return "";
  return EVP_PKEY_get_group_name(key, name, sizeof name, &size) == 1 ? std::string(name, size) : "";
}

// Returns a text such as "RSA of 1024 bits" or "EC secp256k1 of 256 bits".
std::string describe(EVP_PKEY* key) {
  const char* name = EVP_PKEY_get0_type_name(key);
  const auto group = EVP_PKEY_is_a(key, "EC") == 1 ? group_name(key) : "";
  return std::string(name != nullptr ? name : "unknown") + (group.empty() ? "" : " ") + group +
         " of " + std::to_string(EVP_PKEY_get_bits(key)) + " bits";
}

}  // namespace

// A NUL inside a name is refused: printed as a C string, it would read as another, shorter name.
Status check_name(const X509_NAME* name, const char* which) {
  const int count = X509_NAME_entry_count(name);
  if (count > static_cast<int>(kMaxNameAttributes))
    return fail(Code::name_not_allowed,
                {.field = which,
                 .expected = "at most " + std::to_string(kMaxNameAttributes) + " attributes",
                 .found = std::to_string(count)});
  for (int i = 0; i < count; ++i)
    if (!to_utf8(X509_NAME_ENTRY_get_data(X509_NAME_get_entry(name, i))))
      return fail(Code::name_not_allowed, {.field = which,
                                           .expected = "text without NUL octets",
                                           .found = name_rfc2253(name).substr(0, 256)});
  return {};
}

std::string serial_text(const ASN1_INTEGER* serial) {
  const BignumPtr number(ASN1_INTEGER_to_BN(serial, nullptr));
  const OpensslTextPtr hex(number ? BN_bn2hex(number.get()) : nullptr);
  return hex ? hex.get() : "";
}

std::optional<CrlNumber> number_of(const X509_CRL* crl) {
  const Asn1IntegerPtr number(
      static_cast<ASN1_INTEGER*>(X509_CRL_get_ext_d2i(crl, NID_crl_number, nullptr, nullptr)));
  ERR_clear_error();
  if (!number || ASN1_STRING_type(number.get()) == V_ASN1_NEG_INTEGER) return std::nullopt;
  return CrlNumber::from_octets({ASN1_STRING_get0_data(number.get()),
                                 static_cast<std::size_t>(ASN1_STRING_length(number.get()))});
}

std::string key_id_text(const ASN1_OCTET_STRING* id) {
  if (id == nullptr) return {};
  return to_hex({ASN1_STRING_get0_data(id), static_cast<std::size_t>(ASN1_STRING_length(id))});
}

Result<KeyAlgorithm> judge_key(EVP_PKEY* key, std::string_view type) {
  constexpr const char* kAllowed = "RSA of 2048 bits or more, EC P-256 or EC P-384";
  if (key == nullptr)
    return openssl_error(Code::key_not_allowed,
                         {.expected = kAllowed, .found = "a key of " + std::string(type)});
  const int bits = EVP_PKEY_get_bits(key);
  if (EVP_PKEY_is_a(key, "RSA") && bits >= kMinRsaBits && bits <= kMaxRsaBits)
    return KeyAlgorithm{KeyKind::rsa, bits};
  if (EVP_PKEY_is_a(key, "EC")) {
    const auto group = group_name(key);
    if (group == "prime256v1") return KeyAlgorithm{KeyKind::ec_p256, 256};
    if (group == "secp384r1") return KeyAlgorithm{KeyKind::ec_p384, 384};
  }
  take_openssl_reason();
  return fail(Code::key_not_allowed, {.expected = kAllowed, .found = describe(key)});
}

}  // namespace ddssec::pki
