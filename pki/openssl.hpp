// Internal to pki/: OpenSSL's errors, and the times, names, numbers and keys of its objects.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <openssl/err.h>
#include <openssl/pem.h>

#include "base/bytes.hpp"
#include "base/clock.hpp"
#include "base/result.hpp"
#include "pki/certificate.hpp"
#include "pki/crl_number.hpp"
#include "pki/openssl_pointers.hpp"

namespace ddssec::pki {

/// Returns the last reason in OpenSSL's queue, or "" if there is none, and empties the queue.
std::string take_openssl_reason();

/// Makes an error with OpenSSL's last reason as its note.
std::unexpected<Error> openssl_error(Code code, ErrorDetails details = {});

/// Makes a reading BIO over borrowed octets; nullptr if they are too many for OpenSSL.
BioPtr bio_over(BytesView octets);

/// Returns a key identifier in hexadecimal digits; "" for nullptr.
std::string key_id_text(const ASN1_OCTET_STRING* id);

/// Returns the number of a list; empty if it has none or a negative one.
std::optional<CrlNumber> number_of(const X509_CRL* crl);

/// Returns the content of a memory BIO; valid until it changes.
BytesView bio_octets(const BioPtr& bio);

/// Converts a time of a certificate or revocation list. Error: malformed if OpenSSL cannot read it.
Result<WallTime> to_wall_time(const ASN1_TIME* time);

/// Converts the time to the form that certificates use (UTCTime up to 2049). Error: internal.
Result<Asn1TimePtr> to_asn1_time(WallTime time);

/// Returns RFC 2253 text: last RDN first, non-ASCII octets escaped.
std::string name_rfc2253(const X509_NAME* name);

/// Succeeds if a subject or issuer name has an allowed form. Error: name_not_allowed.
Status check_name(const X509_NAME* name, const char* which);

/// Returns a serial number in upper-case hexadecimal digits; "" if it cannot be read.
std::string serial_text(const ASN1_INTEGER* serial);

/// Returns a UTF-8 copy of an attribute's value; empty if it is not text or contains a NUL.
std::optional<std::string> to_utf8(const ASN1_STRING* value);

/// The limits for the size of an RSA key, in bits.
inline constexpr int kMinRsaBits = 2048;
inline constexpr int kMaxRsaBits = 16384;

/// Returns the kind of an allowed public key: RSA of 2048 to 16384 bits, EC P-256 and P-384 with a
/// named curve. Error: key_not_allowed with algorithm and size, or with `type` if `key` is nullptr
/// because OpenSSL could not decode it.
Result<KeyAlgorithm> judge_key(EVP_PKEY* key, std::string_view type = "unknown type");

}  // namespace ddssec::pki
