#include "pki/authority.hpp"

#include <algorithm>
#include <array>
#include <unordered_set>
#include <vector>

#include "base/tool_code.hpp"
#include "pki/mime.hpp"
#include "pki/ocsp_address.hpp"
#include "pki/openssl.hpp"
#include "pki/pki_access.hpp"
#include "pki/self_signed.hpp"
#include "pki/subject_name.hpp"

namespace ddssec::pki {
namespace {

const EVP_MD* digest_of(const PrivateKey& key) {
  return key.algorithm().kind == KeyKind::ec_p384 ? EVP_sha384() : EVP_sha256();
}

bool add_attribute(X509_NAME* name, const NameAttribute& attribute, bool is_joined) {
  const auto value = as_bytes(attribute.value);
  return X509_NAME_add_entry_by_txt(name, attribute.type.c_str(), MBSTRING_UTF8, value.data(),
                                    static_cast<int>(value.size()), -1, is_joined ? -1 : 0) == 1;
}

// Returns the attributes' indexes in the order of the DER name: RDN by RDN from the root.
std::vector<std::vector<std::size_t>> rdns_from_root(const SubjectName& subject) {
  std::vector<std::vector<std::size_t>> rdns;
  for (std::size_t i = 0; i < subject.attributes().size(); ++i) {
    if (!subject.is_joined(i)) rdns.emplace_back();
    rdns.back().push_back(i);
  }
  if (!subject.is_root_first()) std::ranges::reverse(rdns);
  return rdns;
}

// An issued subject must fit into its line of the CA's log.
Status check_subject_length(const X509_NAME* subject) {
  const auto text = name_rfc2253(subject);
  if (text.size() <= kMaxIssuedSubjectOctets) return {};
  return fail(tool_code::name_too_long,
              {.expected = "at most " + std::to_string(kMaxIssuedSubjectOctets) + " octets",
               .found = std::to_string(text.size()) + " octets"});
}

Result<NamePtr> make_name(std::string_view text) {
  DDSSEC_ASSIGN_OR_RETURN(const auto subject, SubjectName::parse(text));
  NamePtr name(X509_NAME_new());
  if (!name) return openssl_error(Code::internal);
  for (const auto& rdn : rdns_from_root(subject))
    for (std::size_t i : rdn)
      if (!add_attribute(name.get(), subject.attributes()[i], i != rdn.front()))
        return openssl_error(
            Code::subject_name_malformed,
            {.field = subject.attributes()[i].type, .found = subject.attributes()[i].value});
  DDSSEC_RETURN_IF_ERROR(check_subject_length(name.get()));
  return name;
}

// Sets a serial number with 126 random bits, so that it is unpredictable (the CA/Browser baseline
// asks for 64).
Status set_serial(X509* x509, Random& random) {
  std::array<std::uint8_t, 16> octets{};
  DDSSEC_RETURN_IF_ERROR(random.fill(octets));
  octets[0] = static_cast<std::uint8_t>((octets[0] & 0x7f) | 0x40);
  const BignumPtr number(BN_bin2bn(octets.data(), static_cast<int>(octets.size()), nullptr));
  if (!number || BN_to_ASN1_INTEGER(number.get(), X509_get_serialNumber(x509)) == nullptr)
    return openssl_error(Code::internal);
  return {};
}

bool add_extension(X509* x509, X509V3_CTX* context, int nid, const std::string& value) {
  const ExtensionPtr extension(X509V3_EXT_conf_nid(nullptr, context, nid, value.c_str()));
  return extension && X509_add_ext(x509, extension.get(), -1) == 1;
}

// Builds the extension without X509V3_EXT_conf_nid, whose syntax takes a comma in the URL for the
// start of another value.
bool add_ocsp_responder(X509* x509, const std::string& url) {
  const AccessPtr access(AUTHORITY_INFO_ACCESS_new());
  auto* entry = ACCESS_DESCRIPTION_new();
  if (!access || entry == nullptr || sk_ACCESS_DESCRIPTION_push(access.get(), entry) <= 0) {
    ACCESS_DESCRIPTION_free(entry);
    return false;
  }
  ASN1_OBJECT_free(entry->method);
  entry->method = OBJ_nid2obj(NID_ad_OCSP);
  auto* text = ASN1_IA5STRING_new();
  if (text == nullptr) return false;
  GENERAL_NAME_set0_value(entry->location, GEN_URI, text);
  return ASN1_STRING_set(text, url.data(), static_cast<int>(url.size())) == 1 &&
         X509_add1_ext_i2d(x509, NID_info_access, access.get(), 0, X509V3_ADD_DEFAULT) == 1;
}

Status add_extensions(X509* x509, X509* issuer, const CertificateTemplate& content) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, x509, nullptr, nullptr, 0);
  std::string constraints = content.is_ca ? "critical,CA:TRUE" : "critical,CA:FALSE";
  if (content.is_ca && content.path_length)
    constraints += ",pathlen:" + std::to_string(*content.path_length);
  const bool added =
      add_extension(x509, &context, NID_basic_constraints, constraints) &&
      (content.key_usage.empty() ||
       add_extension(x509, &context, NID_key_usage, content.key_usage)) &&
      add_extension(x509, &context, NID_subject_key_identifier, "hash") &&
      // For a self-signed certificate the issuer is x509 itself; its subjectKeyIdentifier was added
      // one line above.
      add_extension(x509, &context, NID_authority_key_identifier,
                    issuer == x509 || X509_get0_subject_key_id(issuer) ? "keyid" : "issuer") &&
      (content.ocsp_responder.empty() || add_ocsp_responder(x509, content.ocsp_responder));
  if (!added) return openssl_error(Code::internal, {.field = "extensions"});
  return {};
}

struct Subject {
  const X509_NAME* name;
  EVP_PKEY* key;
};

// Builds and signs a certificate. If `issuer` is null, the certificate is self-signed.
Result<Certificate> build(const CertificateTemplate& content, Subject subject,
                          const Certificate* issuer, const PrivateKey& signing_key,
                          Random& random) {
  const X509Ptr x509(X509_new());
  X509* by = issuer != nullptr ? impl_of(*issuer).x509.get() : x509.get();
  DDSSEC_ASSIGN_OR_RETURN(const auto from, to_asn1_time(content.validity.not_before));
  DDSSEC_ASSIGN_OR_RETURN(const auto until, to_asn1_time(content.validity.not_after));
  if (!x509 || X509_set_version(x509.get(), X509_VERSION_3) != 1 ||
      X509_set_subject_name(x509.get(), subject.name) != 1 ||
      X509_set_issuer_name(x509.get(), X509_get_subject_name(by)) != 1 ||
      X509_set_pubkey(x509.get(), subject.key) != 1 ||
      X509_set1_notBefore(x509.get(), from.get()) != 1 ||
      X509_set1_notAfter(x509.get(), until.get()) != 1)
    return openssl_error(Code::internal);
  DDSSEC_RETURN_IF_ERROR(set_serial(x509.get(), random));
  DDSSEC_RETURN_IF_ERROR(add_extensions(x509.get(), by, content));
  unsigned char* der = nullptr;
  const bool signed_ok =
      X509_sign(x509.get(), impl_of(signing_key).pkey.get(), digest_of(signing_key)) > 0;
  const int size = signed_ok ? i2d_X509(x509.get(), &der) : -1;
  const OpensslMemoryPtr owner(der);
  if (size <= 0) return openssl_error(Code::internal);
  return Certificate::from_der(BytesView(der, static_cast<std::size_t>(size)));
}

CertificateTemplate ca_template(std::string_view subject, Validity validity) {
  return {.subject = std::string(subject),
          .validity = validity,
          .is_ca = true,
          .key_usage = std::string(kCaKeyUsage)};
}

// Returns the template of a certificate that replaces `old`.
CertificateTemplate template_of_successor(const Certificate& old, Validity validity) {
  if (!old.is_ca())
    return {.subject = {}, .validity = validity, .ocsp_responder = ocsp_responder_of(old)};
  auto content = ca_template("", validity);
  content.path_length = old.path_length();
  return content;
}

Result<RequestPtr> parsed_request(BytesView pem) {
  if (pem.size() > kMaxCertificateOctets)
    return fail(Code::request_invalid, {.note = "it is too long"});
  const BioPtr bio = bio_over(pem);
  RequestPtr request(PEM_read_bio_X509_REQ(bio.get(), nullptr, nullptr, nullptr));
  EVP_PKEY* key = request ? X509_REQ_get0_pubkey(request.get()) : nullptr;
  // The signature shows that the requester has the private key.
  if (key == nullptr || X509_REQ_verify(request.get(), key) != 1)
    return openssl_error(Code::request_invalid);
  DDSSEC_RETURN_IF_ERROR(judge_key(key));
  return request;
}

std::string bio_text(const BioPtr& bio) { return std::string(as_text(bio_octets(bio))); }

Result<Asn1IntegerPtr> to_serial(const std::string& hex) {
  constexpr std::size_t kMaxDigits = 64;  // RFC 5280 4.1.2.2 allows 40
  BIGNUM* parsed = nullptr;
  const int digits = hex.size() <= kMaxDigits ? BN_hex2bn(&parsed, hex.c_str()) : 0;
  const BignumPtr number(parsed);
  Asn1IntegerPtr out(number ? BN_to_ASN1_INTEGER(number.get(), nullptr) : nullptr);
  if (!out || hex.empty() || digits != static_cast<int>(hex.size()))
    return openssl_error(Code::crl_malformed,
                         {.field = "serial number", .found = hex.substr(0, kMaxDigits)});
  return out;
}

bool add_reason(X509_REVOKED* entry, RevocationReason reason) {
  if (reason == RevocationReason::unspecified) return true;  // RFC 5280 5.3.1: it should be absent
  const Asn1EnumeratedPtr value(ASN1_ENUMERATED_new());
  return value && ASN1_ENUMERATED_set(value.get(), static_cast<long>(reason)) == 1 &&
         X509_REVOKED_add1_ext_i2d(entry, NID_crl_reason, value.get(), 0, 0) == 1;
}

Status add_revoked(X509_CRL* crl, const Revocation& revocation) {
  RevokedPtr entry(X509_REVOKED_new());
  DDSSEC_ASSIGN_OR_RETURN(const auto serial, to_serial(revocation.serial));
  DDSSEC_ASSIGN_OR_RETURN(const auto when, to_asn1_time(revocation.time));
  if (!entry || X509_REVOKED_set_serialNumber(entry.get(), serial.get()) != 1 ||
      X509_REVOKED_set_revocationDate(entry.get(), when.get()) != 1 ||
      !add_reason(entry.get(), revocation.reason) || X509_CRL_add0_revoked(crl, entry.get()) != 1)
    return openssl_error(Code::internal);
  static_cast<void>(entry.release());  // the list owns it now
  return {};
}

Status add_crl_extensions(X509_CRL* crl, X509* issuer, const CrlNumber& number) {
  X509V3_CTX context;
  X509V3_set_ctx(&context, issuer, nullptr, nullptr, crl, 0);
  const auto octets = number.octets();
  const BignumPtr value(BN_bin2bn(octets.data(), static_cast<int>(octets.size()), nullptr));
  const Asn1IntegerPtr encoded_number(value ? BN_to_ASN1_INTEGER(value.get(), nullptr) : nullptr);
  const ExtensionPtr key_id(
      X509V3_EXT_conf_nid(nullptr, &context, NID_authority_key_identifier,
                          X509_get0_subject_key_id(issuer) ? "keyid" : "issuer"));
  if (!encoded_number || !key_id || X509_CRL_add_ext(crl, key_id.get(), -1) != 1 ||
      X509_CRL_add1_ext_i2d(crl, NID_crl_number, encoded_number.get(), 0, 0) != 1)
    return openssl_error(Code::internal);
  return {};
}

// Returns the DER of the detached signature over `content`, including signing time and certificate.
Result<Bytes> detached_signature(const Credential& signer, BytesView content, WallTime time) {
  constexpr unsigned kFlags = CMS_DETACHED | CMS_BINARY;
  const CmsPtr cms(CMS_sign(nullptr, nullptr, nullptr, nullptr, kFlags | CMS_PARTIAL));
  const BioPtr data = bio_over(content);
  DDSSEC_ASSIGN_OR_RETURN(const auto signing_time, to_asn1_time(time));
  CMS_SignerInfo* info =
      cms ? CMS_add1_signer(cms.get(), impl_of(signer.certificate).x509.get(),
                            impl_of(signer.key).pkey.get(), digest_of(signer.key),
                            kFlags | CMS_PARTIAL | CMS_NOSMIMECAP)
          : nullptr;
  if (info == nullptr || !data ||
      CMS_signed_add1_attr_by_NID(info, NID_pkcs9_signingTime, ASN1_STRING_type(signing_time.get()),
                                  signing_time.get(), -1) != 1 ||
      CMS_final(cms.get(), data.get(), nullptr, kFlags) != 1)
    return openssl_error(Code::internal);
  unsigned char* der = nullptr;
  const int size = i2d_CMS_ContentInfo(cms.get(), &der);
  const OpensslMemoryPtr owner(der);
  if (size <= 0) return openssl_error(Code::internal);
  return Bytes(der, der + size);
}

std::string base64_lines(BytesView octets) {
  constexpr std::size_t kColumns = 64;
  std::vector<std::uint8_t> text(octets.size() / 3 * 4 + 5);
  const int size = EVP_EncodeBlock(text.data(), octets.data(), static_cast<int>(octets.size()));
  const auto all = as_text(BytesView(text).first(static_cast<std::size_t>(size)));
  std::string out;
  for (std::size_t at = 0; at < all.size(); at += kColumns)
    out.append(all.substr(at, kColumns)).append("\n");
  return out;
}

Result<std::string> random_boundary(Random& random) {
  std::array<std::uint8_t, 16> octets{};
  DDSSEC_RETURN_IF_ERROR(random.fill(octets));
  return "----" + to_hex(octets);
}

}  // namespace

namespace {

Result<std::string> request_for(const PrivateKey& key, const X509_NAME* name) {
  const RequestPtr request(X509_REQ_new());
  EVP_PKEY* pkey = impl_of(key).pkey.get();
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (!request || !bio || X509_REQ_set_version(request.get(), 0) != 1 ||
      X509_REQ_set_subject_name(request.get(), name) != 1 ||
      X509_REQ_set_pubkey(request.get(), pkey) != 1 ||
      X509_REQ_sign(request.get(), pkey, digest_of(key)) <= 0 ||
      PEM_write_bio_X509_REQ(bio.get(), request.get()) != 1)
    return openssl_error(Code::internal);
  return bio_text(bio);
}

}  // namespace

Result<std::string> make_request(const PrivateKey& key, std::string_view subject) {
  DDSSEC_ASSIGN_OR_RETURN(const auto name, make_name(subject));
  return request_for(key, name.get());
}

Result<std::string> make_request(const PrivateKey& key, const Certificate& old) {
  return request_for(key, X509_get_subject_name(impl_of(old).x509.get()));
}

Result<Credential> self_sign(const CertificateTemplate& content, PrivateKey key, Random& random) {
  DDSSEC_ASSIGN_OR_RETURN(const auto name, make_name(content.subject));
  DDSSEC_ASSIGN_OR_RETURN(auto certificate, build(content, {name.get(), impl_of(key).pkey.get()},
                                                  nullptr, key, random));
  return Credential{std::move(certificate), std::move(key)};
}

Result<Authority> Authority::create_root(std::string_view subject, KeySpec key, Validity validity,
                                         Random& random) {
  DDSSEC_ASSIGN_OR_RETURN(auto private_key, PrivateKey::generate(key.kind, key.bits));
  return create_root(subject, std::move(private_key), validity, random);
}

Result<Authority> Authority::create_root(std::string_view subject, PrivateKey key,
                                         Validity validity, Random& random) {
  auto content = ca_template(subject, validity);
  content.path_length = 1;
  DDSSEC_ASSIGN_OR_RETURN(auto credential, self_sign(content, std::move(key), random));
  return Authority(std::move(credential));
}

Result<Authority> Authority::create(std::string_view subject, KeySpec key, Validity validity,
                                    Random& random) {
  DDSSEC_ASSIGN_OR_RETURN(auto own, PrivateKey::generate(key.kind, key.bits));
  DDSSEC_ASSIGN_OR_RETURN(auto credential,
                          self_sign(ca_template(subject, validity), std::move(own), random));
  return Authority(std::move(credential));
}

Result<Authority> Authority::load(Certificate certificate, PrivateKey key) {
  if (!certificate.is_ca())
    return fail(Code::not_a_ca,
                {.field = certificate.subject(), .expected = "basicConstraints CA:TRUE"});
  DDSSEC_RETURN_IF_ERROR(key.check_fits(certificate));
  return Authority(Credential{std::move(certificate), std::move(key)});
}

Result<Authority> Authority::subordinate(std::string_view subject, KeySpec key, Validity validity,
                                         Random& random) const {
  DDSSEC_ASSIGN_OR_RETURN(auto private_key, PrivateKey::generate(key.kind, key.bits));
  return subordinate(subject, std::move(private_key), validity, random);
}

Result<Authority> Authority::subordinate(std::string_view subject, PrivateKey key,
                                         Validity validity, Random& random) const {
  auto content = ca_template(subject, validity);
  content.path_length = 0;
  DDSSEC_ASSIGN_OR_RETURN(auto certificate, certify(content, key, random));
  return Authority(Credential{std::move(certificate), std::move(key)});
}

Result<Credential> Authority::issue(std::string_view subject, KeySpec key, Validity validity,
                                    Random& random, std::string_view ocsp_responder) const {
  DDSSEC_ASSIGN_OR_RETURN(auto own, PrivateKey::generate(key.kind, key.bits));
  DDSSEC_ASSIGN_OR_RETURN(auto certificate, certify({.subject = std::string(subject),
                                                     .validity = validity,
                                                     .ocsp_responder = std::string(ocsp_responder)},
                                                    own, random));
  return Credential{std::move(certificate), std::move(own)};
}

Result<Certificate> Authority::certify(const CertificateTemplate& content, const PrivateKey& key,
                                       Random& random) const {
  DDSSEC_ASSIGN_OR_RETURN(const auto name, make_name(content.subject));
  return build(content, {name.get(), impl_of(key).pkey.get()}, &self_.certificate, self_.key,
               random);
}

Result<Certificate> Authority::reissue(const Certificate& old, Validity validity, Random& random,
                                       const PrivateKey* key) const {
  X509* x509 = impl_of(old).x509.get();
  return build(template_of_successor(old, validity),
               {X509_get_subject_name(x509),
                key != nullptr ? impl_of(*key).pkey.get() : X509_get0_pubkey(x509)},
               &self_.certificate, self_.key, random);
}

Result<Certificate> Authority::renewed(Validity validity, Random& random) const {
  X509* x509 = impl_of(self_.certificate).x509.get();
  return build(template_of_successor(self_.certificate, validity),
               {X509_get_subject_name(x509), X509_get0_pubkey(x509)}, nullptr, self_.key, random);
}

Result<Certificate> Authority::sign_request(BytesView request_pem, Validity validity,
                                            Random& random, std::string_view ocsp_responder) const {
  DDSSEC_ASSIGN_OR_RETURN(const auto request, parsed_request(request_pem));
  DDSSEC_RETURN_IF_ERROR(check_subject_length(X509_REQ_get_subject_name(request.get())));
  const CertificateTemplate content{
      .subject = {}, .validity = validity, .ocsp_responder = std::string(ocsp_responder)};
  return build(content,
               {X509_REQ_get_subject_name(request.get()), X509_REQ_get0_pubkey(request.get())},
               &self_.certificate, self_.key, random);
}

Result<RequestContent> read_request(BytesView request_pem) {
  DDSSEC_ASSIGN_OR_RETURN(const auto request, parsed_request(request_pem));
  const X509_NAME* subject = X509_REQ_get_subject_name(request.get());
  DDSSEC_ASSIGN_OR_RETURN(const auto key, judge_key(X509_REQ_get0_pubkey(request.get())));
  DDSSEC_RETURN_IF_ERROR(check_name(subject, "subject"));
  DDSSEC_RETURN_IF_ERROR(check_subject_length(subject));
  return RequestContent{name_rfc2253(subject), key};
}

Result<Crl> Authority::make_crl(const CrlTemplate& content) const {
  const CrlPtr crl(X509_CRL_new());
  X509* issuer = impl_of(self_.certificate).x509.get();
  DDSSEC_ASSIGN_OR_RETURN(const auto this_update, to_asn1_time(content.this_update));
  DDSSEC_ASSIGN_OR_RETURN(const auto next_update, to_asn1_time(content.next_update));
  if (!crl || X509_CRL_set_version(crl.get(), X509_CRL_VERSION_2) != 1 ||
      X509_CRL_set_issuer_name(crl.get(), X509_get_subject_name(issuer)) != 1 ||
      X509_CRL_set1_lastUpdate(crl.get(), this_update.get()) != 1 ||
      X509_CRL_set1_nextUpdate(crl.get(), next_update.get()) != 1)
    return openssl_error(Code::internal);
  std::unordered_set<std::string> listed;
  for (const auto& certificate : content.revoked)
    if (listed.insert(certificate.serial()).second)
      DDSSEC_RETURN_IF_ERROR(
          add_revoked(crl.get(), {.serial = certificate.serial(), .time = content.this_update}));
  for (const auto& entry : content.entries)
    if (listed.insert(entry.serial).second) DDSSEC_RETURN_IF_ERROR(add_revoked(crl.get(), entry));
  DDSSEC_RETURN_IF_ERROR(add_crl_extensions(crl.get(), issuer, content.number));
  X509_CRL_sort(crl.get());
  const BioPtr bio(BIO_new(BIO_s_mem()));
  if (!bio || X509_CRL_sign(crl.get(), impl_of(self_.key).pkey.get(), digest_of(self_.key)) <= 0 ||
      i2d_X509_CRL_bio(bio.get(), crl.get()) != 1)
    return openssl_error(Code::internal);
  DDSSEC_ASSIGN_OR_RETURN(auto crls, Crl::all_from(bio_octets(bio)));
  return std::move(crls.front());
}

Result<Bytes> Authority::sign_document(BytesView document, WallTime signing_time,
                                       Random& random) const {
  return pki::sign_document(self_, document, signing_time, random);
}

Result<Bytes> sign_document(const Credential& signer, BytesView document, WallTime signing_time,
                            Random& random) {
  if (as_text(document).find('\0') != std::string_view::npos) return fail(Code::smime_nul);
  auto text = std::string("Content-Type: text/plain\r\n\r\n").append(as_text(document));
  DDSSEC_ASSIGN_OR_RETURN(const auto content, canonical_text(text));
  DDSSEC_ASSIGN_OR_RETURN(const auto signature, detached_signature(signer, content, signing_time));
  DDSSEC_ASSIGN_OR_RETURN(const auto boundary, random_boundary(random));
  const bool sha384 = signer.key.algorithm().kind == KeyKind::ec_p384;
  std::string out = "MIME-Version: 1.0\nContent-Type: multipart/signed; ";
  out.append("protocol=\"application/x-pkcs7-signature\"; micalg=\"")
      .append(sha384 ? "sha-384" : "sha-256")
      .append("\"; boundary=\"" + boundary + "\"\n\nThis is an S/MIME signed message\n\n")
      .append("--" + boundary + "\n")
      .append(as_text(content))
      .append("\n--" + boundary + "\n")
      .append("Content-Type: application/x-pkcs7-signature; name=\"smime.p7s\"\n")
      .append("Content-Transfer-Encoding: base64\n")
      .append("Content-Disposition: attachment; filename=\"smime.p7s\"\n\n")
      .append(base64_lines(signature))
      .append("\n--" + boundary + "--\n\n");
  return to_bytes(as_bytes(out));
}

}  // namespace ddssec::pki
