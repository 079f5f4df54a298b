#include "pki/certificate.hpp"

#include <algorithm>
#include <map>
#include <mutex>

#include "base/text.hpp"
#include "base/uri_source.hpp"
#include "pki/certificate_context.hpp"
#include "pki/certificate_source.hpp"
#include "pki/openssl.hpp"
#include "pki/openssl_guards.hpp"
#include "pki/pem_block.hpp"
#include "pki/pki_access.hpp"

namespace ddssec::pki {
namespace {

constexpr std::string_view kLabel = "CERTIFICATE";

Error malformed_error(std::string note) {
  return Error(Code::certificate_malformed, {.note = std::move(note)});
}

std::string one_line(const X509_NAME* name) {
  const OpensslTextPtr text(X509_NAME_oneline(name, nullptr, 0));
  return text ? text.get() : "";
}

std::string pem_text(BytesView der) {
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (!bio ||
      PEM_write_bio(bio.get(), kLabel.data(), "", der.data(), static_cast<long>(der.size())) <= 0)
    return {};
  return std::string(as_text(bio_octets(bio)));
}

// True for the distinguished encoding (DER). The same certificate in a different encoding would
// have another fingerprint.
bool is_distinguished(const X509* x509, BytesView der) {
  unsigned char* again = nullptr;
  const int size = i2d_X509(x509, &again);
  const OpensslMemoryPtr owner(again);
  return size > 0 && std::ranges::equal(BytesView(again, static_cast<std::size_t>(size)), der);
}

Result<X509Ptr> decode(BytesView der) {
  const auto* position = der.data();
  // OpenSSL frees the object if the octets are not a certificate, but not if only its extensions
  // are invalid.
  X509* made = X509_new_ex(certificate_context(), nullptr);
  const bool read =
      made != nullptr && d2i_X509(&made, &position, static_cast<long>(der.size())) != nullptr;
  X509Ptr x509(made);
  if (!read) return openssl_error(Code::certificate_malformed);
  if (position != der.data() + der.size())
    return std::unexpected(malformed_error("octets follow the certificate"));
  if (!is_distinguished(x509.get(), der))
    return std::unexpected(malformed_error("it is not in the distinguished encoding"));
  DDSSEC_RETURN_IF_ERROR(check_distribution_points(x509.get()));
  // The extensions are read now, so that later use by several threads only reads.
  if (X509_check_purpose(x509.get(), -1, 0) != 1 ||
      (X509_get_extension_flags(x509.get()) & EXFLAG_INVALID) != 0)
    return openssl_error(Code::certificate_malformed, {.field = "extensions"});
  return x509;
}

Result<WallTime> time_of(const ASN1_TIME* time, const char* field) {
  constexpr int kMaxShown = 24;  // octets
  auto out = to_wall_time(time);
  if (out) return out;
  const auto* octets = ASN1_STRING_get0_data(time);
  const auto size = static_cast<std::size_t>(std::clamp(ASN1_STRING_length(time), 0, kMaxShown));
  return fail(Code::certificate_malformed,
              {.field = field,
               .expected = "a date such as 261121000000Z",
               .found = '"' + printable(as_text(BytesView(octets, size))) + '"'});
}

// Returns the key type as named in the certificate. If the type is not allowed, nothing else about
// the key is known.
std::string_view key_type(const X509* x509) {
  ASN1_OBJECT* algorithm = nullptr;
  X509_PUBKEY_get0_param(&algorithm, nullptr, nullptr, nullptr, X509_get_X509_PUBKEY(x509));
  return OBJ_nid2ln(OBJ_obj2nid(algorithm));
}

// Computes all values once, because a certificate is used many times.
Result<std::unique_ptr<const PkiAccess::CertificateImpl>> finish(X509Ptr x509, BytesView der) {
  auto out = std::make_unique<PkiAccess::CertificateImpl>();
  const X509_NAME* subject = X509_get_subject_name(x509.get());
  const X509_NAME* issuer = X509_get_issuer_name(x509.get());
  DDSSEC_RETURN_IF_ERROR(check_name(subject, "subject"));
  DDSSEC_RETURN_IF_ERROR(check_name(issuer, "issuer"));
  out->subject = name_rfc2253(subject);
  out->subject_one_line = one_line(subject);
  out->issuer = name_rfc2253(issuer);
  DDSSEC_ASSIGN_OR_RETURN(
      out->key, with_default_document(judge_key(X509_get0_pubkey(x509.get()), key_type(x509.get())),
                                      "certificate of " + out->subject));
  DDSSEC_ASSIGN_OR_RETURN(out->not_before, time_of(X509_get0_notBefore(x509.get()), "notBefore"));
  DDSSEC_ASSIGN_OR_RETURN(out->not_after, time_of(X509_get0_notAfter(x509.get()), "notAfter"));
  const unsigned char* name_der = nullptr;
  std::size_t name_size = 0;
  if (X509_NAME_get0_der(subject, &name_der, &name_size) != 1)
    return openssl_error(Code::certificate_malformed, {.field = "subject"});
  out->subject_digest = sha256(BytesView(name_der, name_size));
  out->der = to_bytes(der);
  out->fingerprint = sha256(der);
  out->pem = pem_text(der);
  out->x509 = std::move(x509);
  return out;
}

// The certificates in use. Parsing one takes longer than verifying a signature, so certificates
// are shared. Thread-safe.
class CertificateCache {
 public:
  static CertificateCache& instance() {
    static auto* const all = new CertificateCache;  // outlives every thread
    return *all;
  }

  std::shared_ptr<const PkiAccess::CertificateImpl> find(const Sha256Digest& fingerprint) {
    const std::scoped_lock lock(mutex_);
    const auto known = known_.find(fingerprint);
    return known == known_.end() ? nullptr : known->second.lock();
  }

  // Adds a new certificate. When its last holder releases it, it is removed again.
  std::shared_ptr<const PkiAccess::CertificateImpl> share(
      std::unique_ptr<const PkiAccess::CertificateImpl> made) {
    const std::shared_ptr<const PkiAccess::CertificateImpl> out(made.release(),
                                                                [this](const auto* last) {
                                                                  forget(last->fingerprint);
                                                                  delete last;
                                                                });
    const std::scoped_lock lock(mutex_);
    known_.insert_or_assign(out->fingerprint, out);
    return out;
  }

 private:
  // Removes an entry, unless another thread has made the same certificate again meanwhile.
  void forget(const Sha256Digest& fingerprint) {
    const std::scoped_lock lock(mutex_);
    const auto known = known_.find(fingerprint);
    if (known != known_.end() && known->second.expired()) known_.erase(known);
  }

  std::mutex mutex_;
  std::map<Sha256Digest, std::weak_ptr<const PkiAccess::CertificateImpl>> known_;
};

// The error for a file without a PEM certificate. It names DER if the file begins with a SEQUENCE,
// because no product reads DER there.
Error no_pem_block_error(BytesView octets) {
  if (is_der(octets))
    return Error(Code::certificate_malformed,
                 {.expected = "PEM",
                  .found = "DER",
                  .hint = "write it as PEM: openssl x509 -inform DER -in FILE -out FILE.pem"});
  return malformed_error("there is no PEM block CERTIFICATE");
}

Error too_large_error(std::size_t max_octets, std::size_t found) {
  return too_many_octets_error(Code::certificate_too_large, max_octets, found);
}

// Reads the next certificate of a PEM text; nothing at its end.
Result<std::optional<Certificate>> next_certificate(BIO* bio) {
  for (;;) {
    auto block = next_pem_block(bio);
    if (!block) return std::unexpected(malformed_error(block.error().details().note));
    if (!*block) return std::nullopt;
    if ((*block)->label != kLabel) continue;
    DDSSEC_ASSIGN_OR_RETURN(auto certificate, Certificate::from_der((*block)->der));
    return certificate;
  }
}

}  // namespace

std::string to_string(KeyAlgorithm algorithm) {
  switch (algorithm.kind) {
    case KeyKind::rsa:
      return "RSA-" + std::to_string(algorithm.bits);
    case KeyKind::ec_p256:
      return "EC-prime256v1";
    case KeyKind::ec_p384:
      break;
  }
  return "EC-secp384r1";
}

Result<Certificate> Certificate::from_der(BytesView octets) {
  if (octets.size() > kMaxCertificateOctets)
    return std::unexpected(too_large_error(kMaxCertificateOctets, octets.size()));
  auto& cache = CertificateCache::instance();
  if (auto known = cache.find(sha256(octets)))
    return PkiAccess::make<Certificate>(std::move(known));
  DDSSEC_ASSIGN_OR_RETURN(auto decoded, decode(octets));
  DDSSEC_ASSIGN_OR_RETURN(auto checked, finish(std::move(decoded), octets));
  return PkiAccess::make<Certificate>(cache.share(std::move(checked)));
}

Result<Certificate> Certificate::from_pem(BytesView octets) {
  if (octets.size() > kMaxCertificateOctets)
    return std::unexpected(too_large_error(kMaxCertificateOctets, octets.size()));
  if (!octets.empty() && octets.back() == 0) octets = octets.first(octets.size() - 1);
  const BioPtr bio = bio_over(octets);
  DDSSEC_ASSIGN_OR_RETURN(auto certificate, next_certificate(bio.get()));
  if (!certificate) return std::unexpected(no_pem_block_error(octets));
  return *std::move(certificate);
}

Result<std::vector<Certificate>> Certificate::bundle_from_pem(BytesView octets) {
  if (octets.size() > kMaxBundleOctets)
    return std::unexpected(too_large_error(kMaxBundleOctets, octets.size()));
  const BioPtr bio = bio_over(octets);
  std::vector<Certificate> out;
  while (true) {
    DDSSEC_ASSIGN_OR_RETURN(auto certificate, next_certificate(bio.get()));
    if (!certificate) break;

    if (out.size() == kMaxCertificatesInBundle)
      return fail(Code::certificate_too_large,
                  {.expected = "at most " + std::to_string(kMaxCertificatesInBundle) +
                               " certificates in a file"});
    out.push_back(*std::move(certificate));
  }
  if (out.empty()) return std::unexpected(no_pem_block_error(octets));
  return out;
}

BytesView Certificate::der() const { return impl_->der; }
const std::string& Certificate::pem() const { return impl_->pem; }
const Sha256Digest& Certificate::fingerprint() const { return impl_->fingerprint; }
const std::string& Certificate::subject() const { return impl_->subject; }
const std::string& Certificate::subject_one_line() const { return impl_->subject_one_line; }
const std::string& Certificate::issuer() const { return impl_->issuer; }
const Sha256Digest& Certificate::subject_digest() const { return impl_->subject_digest; }
WallTime Certificate::not_before() const { return impl_->not_before; }
WallTime Certificate::not_after() const { return impl_->not_after; }
KeyAlgorithm Certificate::key_algorithm() const { return impl_->key; }
bool Certificate::is_ca() const { return X509_check_ca(impl_->x509.get()) == 1; }
bool Certificate::is_version_1() const { return X509_get_version(impl_->x509.get()) == 0; }

bool Certificate::can_be_anchor() const {
  constexpr int kSelfSignedVersion1 = 3;  // X509_check_ca(3)
  return is_ca() || X509_check_ca(impl_->x509.get()) == kSelfSignedVersion1;
}

bool Certificate::is_ca_by_key_usage_only() const {
  constexpr int kKeyCertSignOnly = 4;  // X509_check_ca(3)
  return X509_check_ca(impl_->x509.get()) == kKeyCertSignOnly;
}

std::string Certificate::signature_digest() const {
  const int algorithm = X509_get_signature_nid(impl_->x509.get());
  if (algorithm == NID_rsassaPss) return "RSASSA-PSS";
  int digest = NID_undef;
  OBJ_find_sigid_algs(algorithm, &digest, nullptr);
  return digest == NID_undef ? "" : OBJ_nid2sn(digest);
}

std::optional<int> Certificate::path_length() const {
  const long length = X509_get_pathlen(impl_->x509.get());
  return length < 0 ? std::nullopt : std::optional(static_cast<int>(length));
}

bool Certificate::is_self_issued() const {
  return X509_NAME_cmp(X509_get_subject_name(impl_->x509.get()),
                       X509_get_issuer_name(impl_->x509.get())) == 0;
}

bool Certificate::is_issued_by(const Certificate& ca) const {
  X509* issuer = impl_of(ca).x509.get();
  const bool is_by =
      X509_NAME_cmp(X509_get_issuer_name(impl_->x509.get()), X509_get_subject_name(issuer)) == 0 &&
      X509_verify(impl_->x509.get(), X509_get0_pubkey(issuer)) == 1;
  take_openssl_reason();
  return is_by;
}

std::string Certificate::serial() const {
  return serial_text(X509_get0_serialNumber(impl_->x509.get()));
}

}  // namespace ddssec::pki
