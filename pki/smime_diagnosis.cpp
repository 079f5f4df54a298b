#include "pki/smime_diagnosis.hpp"

#include <algorithm>
#include <optional>

#include <openssl/pkcs7.h>

#include "pki/certificate_source.hpp"
#include "pki/mime.hpp"
#include "pki/openssl.hpp"
#include "pki/openssl_guards.hpp"
#include "pki/pki_access.hpp"
#include "pki/signing_time.hpp"
#include "pki/unverified_document.hpp"

namespace ddssec::pki {
namespace {

using Pkcs7Ptr = std::unique_ptr<PKCS7, Deleter<PKCS7_free>>;

// A signature as OpenSSL finds it, and the signed text if that is beside the signature.
struct ParsedSignature {
  Pkcs7Ptr pkcs7;
  BioPtr beside;
};

Bytes read_all(BIO* bio) {
  Bytes out;
  unsigned char block[4096];
  for (int size; (size = BIO_read(bio, block, sizeof block)) > 0;) {
    if (out.size() + static_cast<std::size_t>(size) > kMaxDocumentOctets) break;
    out.insert(out.end(), block, block + size);
  }
  return out;
}

ParsedSignature parse_smime(BytesView file) {
  const BioPtr in = bio_over(file);
  BIO* beside = nullptr;
  Pkcs7Ptr pkcs7(in ? SMIME_read_PKCS7(in.get(), &beside) : nullptr);
  return {std::move(pkcs7), BioPtr(beside)};
}

Pkcs7Ptr parse_pem(BytesView file) {
  const BioPtr in = bio_over(file);
  return Pkcs7Ptr(in ? PEM_read_bio_PKCS7(in.get(), nullptr, nullptr, nullptr) : nullptr);
}

Pkcs7Ptr parse_der(BytesView file) {
  const auto* position = file.data();
  return Pkcs7Ptr(d2i_PKCS7(nullptr, &position, static_cast<long>(file.size())));
}

// Returns nullptr unless the octets are SignedData.
CmsPtr parse_cms(BytesView der) {
  const auto* position = der.data();
  CmsPtr cms(d2i_CMS_ContentInfo(nullptr, &position, static_cast<long>(der.size())));
  return cms && OBJ_obj2nid(CMS_get0_type(cms.get())) == NID_pkcs7_signed ? std::move(cms)
                                                                          : nullptr;
}

// Returns the text inside an opaque signature.
Bytes inner_text(PKCS7* pkcs7) {
  if (PKCS7_type_is_signed(pkcs7) == 0 || PKCS7_get_detached(pkcs7) != 0 ||
      pkcs7->d.sign == nullptr || pkcs7->d.sign->contents == nullptr ||
      PKCS7_type_is_data(pkcs7->d.sign->contents) == 0)
    return {};
  const ASN1_OCTET_STRING* data = pkcs7->d.sign->contents->d.data;
  if (data == nullptr) return {};
  return to_bytes(BytesView(ASN1_STRING_get0_data(data),
                            static_cast<std::size_t>(std::max(ASN1_STRING_length(data), 0))));
}

void describe_signer(PKCS7* pkcs7, DocumentForm& form) {
  auto* signers = PKCS7_get_signer_info(pkcs7);
  if (signers == nullptr || sk_PKCS7_SIGNER_INFO_num(signers) < 1) return;
  const auto* issuer_and_serial = sk_PKCS7_SIGNER_INFO_value(signers, 0)->issuer_and_serial;
  if (issuer_and_serial == nullptr) return;
  form.signer_issuer = name_rfc2253(issuer_and_serial->issuer);
  const BignumPtr number(ASN1_INTEGER_to_BN(issuer_and_serial->serial, nullptr));
  const OpensslTextPtr hex(number ? BN_bn2hex(number.get()) : nullptr);
  form.signer_serial = hex ? hex.get() : "";
}

Bytes der_of(X509* certificate) {
  Bytes der(static_cast<std::size_t>(std::max(i2d_X509(certificate, nullptr), 0)));
  auto* position = der.data();
  if (!der.empty()) i2d_X509(certificate, &position);
  return der;
}

void add_signer_certificates(PKCS7* pkcs7, DocumentForm& form) {
  auto* signers = PKCS7_get_signer_info(pkcs7);
  const auto count = signers != nullptr ? sk_PKCS7_SIGNER_INFO_num(signers) : 0;
  for (int i = 0; i < count && form.signer_certificates.size() < DocumentForm::kMaxEmbedded; ++i) {
    auto* certificate = PKCS7_cert_from_signer_info(pkcs7, sk_PKCS7_SIGNER_INFO_value(signers, i));
    if (certificate == nullptr) continue;
    form.signer_certificates.push_back(der_of(certificate));
  }
}

void describe_embedded(PKCS7* pkcs7, DocumentForm& form) {
  if (PKCS7_type_is_signed(pkcs7) == 0 || pkcs7->d.sign == nullptr) return;
  const auto* certificates = pkcs7->d.sign->cert;
  const int count = certificates != nullptr ? sk_X509_num(certificates) : 0;
  for (int i = 0; i < count && form.embedded.size() < DocumentForm::kMaxEmbedded; ++i)
    form.embedded.push_back(name_rfc2253(X509_get_subject_name(sk_X509_value(certificates, i))));
}

// CMS, unlike PKCS#7, can name the signer by the identifier of its key.
void describe_cms(CMS_ContentInfo* cms, DocumentForm& form) {
  auto* signers = CMS_get0_SignerInfos(cms);
  auto* certificates = CMS_get1_certs(cms);
  for (int i = 0; i < sk_X509_num(certificates); ++i) {
    X509* certificate = sk_X509_value(certificates, i);
    if (form.embedded.size() < DocumentForm::kMaxEmbedded)
      form.embedded.push_back(name_rfc2253(X509_get_subject_name(certificate)));
    for (int at = 0; at < sk_CMS_SignerInfo_num(signers); ++at)
      if (form.signer_certificates.size() < DocumentForm::kMaxEmbedded &&
          CMS_SignerInfo_cert_cmp(sk_CMS_SignerInfo_value(signers, at), certificate) == 0)
        form.signer_certificates.push_back(der_of(certificate));
  }
  sk_X509_pop_free(certificates, X509_free);
  ASN1_OCTET_STRING* key_id = nullptr;
  if (sk_CMS_SignerInfo_num(signers) > 0 &&
      CMS_SignerInfo_get0_signer_id(sk_CMS_SignerInfo_value(signers, 0), &key_id, nullptr,
                                    nullptr) == 1)
    form.signer_key_id = key_id_text(key_id);
}

std::optional<WallTime> signing_time_in(BytesView signature) {
  const auto cms = parse_cms(signature);
  auto* const signers = cms ? CMS_get0_SignerInfos(cms.get()) : nullptr;
  if (sk_CMS_SignerInfo_num(signers) < 1) return std::nullopt;
  return signing_time_of(sk_CMS_SignerInfo_value(signers, 0));
}

// Removes "Content-Type: text/plain ..." and the blank line from the text.
void take_text_header(DocumentForm& form) {
  constexpr std::string_view kHeader = "content-type: text/plain";
  const auto text = as_text(form.unverified_text);
  const bool has = std::ranges::equal(text.substr(0, kHeader.size()), kHeader, {}, [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  if (!has) return;
  form.has_text_header = true;
  const auto crlf = text.find("\r\n\r\n");
  const auto lf = text.find("\n\n");
  const auto end =
      std::min(crlf == text.npos ? text.npos : crlf + 4, lf == text.npos ? text.npos : lf + 2);
  form.unverified_text = to_bytes(as_bytes(text.substr(std::min(end, text.size()))));
}

// The number of the file's line at which `text` begins. OpenSSL does not report it, so the first
// non-blank line of the text is searched for.
int first_line_in(std::string_view file, std::string_view text) {
  const auto begin = text.find_first_not_of(" \t\r\n");
  if (begin == text.npos) return 1;
  const auto place = file.find(text.substr(begin, text.find_first_of("\r\n", begin) - begin));
  if (place == file.npos) return 1;
  const auto breaks = [](std::string_view part) { return std::ranges::count(part, '\n'); };
  return static_cast<int>(1 + breaks(file.substr(0, place)) - breaks(text.substr(0, begin)));
}

Bytes der_of(PKCS7* pkcs7) {
  Bytes out(static_cast<std::size_t>(std::max(i2d_PKCS7(pkcs7, nullptr), 0)));
  auto* position = out.data();
  i2d_PKCS7(pkcs7, &position);
  return out;
}

// Reads the text as the plugins do. Returns false if they cannot read it.
bool read_as_plugins_do(BytesView file, DocumentForm& form) {
  const auto document = read_document(file);
  const auto pkcs7 = document ? parse_der(document->signature) : nullptr;
  const auto cms = document && !pkcs7 ? parse_cms(document->signature) : nullptr;
  if (!pkcs7 && !cms) return false;
  form.wrapping = DocumentWrapping::multipart;
  form.has_text_header = true;
  form.unverified_text = to_bytes(document->text());
  form.first_line = document->first_line;
  form.signing_time = signing_time_in(document->signature);
  if (const auto same = check_same_reading(*document, file); !same) form.ambiguous = same.error();
  if (cms) {
    describe_cms(cms.get(), form);
    return true;
  }
  describe_signer(pkcs7.get(), form);
  describe_embedded(pkcs7.get(), form);
  add_signer_certificates(pkcs7.get(), form);
  return true;
}

DocumentWrapping wrapping_of(BytesView file, ParsedSignature& parsed) {
  parsed = parse_smime(file);
  if (parsed.pkcs7) return parsed.beside ? DocumentWrapping::multipart : DocumentWrapping::opaque;
  const auto text = as_text(file);
  const auto first = text.find_first_not_of(" \t\r\n");
  if (first != text.npos && text[first] == '<') return DocumentWrapping::none;
  if ((parsed.pkcs7 = parse_pem(file))) return DocumentWrapping::pem;
  if ((parsed.pkcs7 = parse_der(file))) return DocumentWrapping::der;
  return DocumentWrapping::unknown;
}

StorePtr empty_store(WallTime now) {
  StorePtr store(X509_STORE_new());
  if (!store) return nullptr;
  X509_VERIFY_PARAM_set_time(X509_STORE_get0_param(store.get()), to_time_t(now));
  return store;
}

StorePtr store_of(const std::vector<Certificate>& cas, WallTime now) {
  auto store = empty_store(now);
  if (!store) return nullptr;
  for (const auto& ca : cas) X509_STORE_add_cert(store.get(), impl_of(ca).x509.get());
  return store;
}

// Returns nullptr if the file has no certificate.
StorePtr store_of(BytesView ca_file, std::size_t count, WallTime now) {
  const BioPtr in = bio_over(ca_file);
  auto store = empty_store(now);
  std::size_t read = 0;
  for (; in && store && read < count; ++read) {
    const X509Ptr ca(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr));
    if (!ca) break;
    X509_STORE_add_cert(store.get(), ca.get());
  }
  take_openssl_reason();  // the error at the end of the file
  return read > 0 ? std::move(store) : nullptr;
}

std::string algorithm_for_fastdds(const X509* certificate) {
  switch (X509_get_signature_nid(certificate)) {
    case NID_ecdsa_with_SHA256:
      return "ECDSA";
    case NID_sha256WithRSAEncryption:
      return "RSA";
    default:
      return {};
  }
}

Status verify_with_store(BytesView file, const StorePtr& store) {
  if (file.size() > kMaxDocumentOctets) return fail(Code::smime_too_large);
  const auto parsed = parse_smime(file);
  if (!parsed.pkcs7) return openssl_error(Code::smime_malformed);
  const BioPtr out(BIO_new(BIO_s_mem()));
  if (!store || !out) return openssl_error(Code::internal);
  return verify_pkcs7(parsed.pkcs7.get(), store.get(), parsed.beside.get(), out.get(), PKCS7_TEXT);
}

}  // namespace

std::string_view to_string(DocumentWrapping wrapping) {
  switch (wrapping) {
    case DocumentWrapping::none:
      return "unsigned XML";
    case DocumentWrapping::multipart:
      return "multipart/signed";
    case DocumentWrapping::opaque:
      return "opaque application/pkcs7-mime";
    case DocumentWrapping::pem:
      return "PKCS#7 in PEM";
    case DocumentWrapping::der:
      return "PKCS#7 in DER";
    case DocumentWrapping::unknown:
      break;
  }
  return "neither XML nor a signature";
}

std::string signer_words(const DocumentForm& form) {
  if (!form.signer_key_id.empty())
    return "the key " + form.signer_key_id + " (subject key identifier)";
  return "serial " + form.signer_serial + " of " + form.signer_issuer;
}

Status check_same_reading(const UnverifiedDocument& ours, BytesView file) {
  const auto parsed = parse_smime(file);
  if (!parsed.pkcs7) return {};
  const auto pkcs7 = parse_der(ours.signature);
  const bool is_same_text = parsed.beside && read_all(parsed.beside.get()) == ours.signed_octets;
  if (is_same_text && pkcs7 && der_of(pkcs7.get()) == der_of(parsed.pkcs7.get())) return {};
  return fail(Code::smime_malformed, {.expected = "one text and one signature for every reader",
                                      .found = is_same_text ? "another signature for OpenSSL"
                                                            : "another text for OpenSSL"});
}

DocumentForm examine_document(BytesView file) {
  DocumentForm form;
  if (file.size() > kMaxDocumentOctets) return form;
  if (read_as_plugins_do(file, form)) {
    take_openssl_reason();
    return form;
  }
  ParsedSignature parsed;
  form.wrapping = wrapping_of(file, parsed);
  if (form.wrapping == DocumentWrapping::none) form.unverified_text = to_bytes(file);
  if (parsed.pkcs7) {
    form.unverified_text =
        parsed.beside ? read_all(parsed.beside.get()) : inner_text(parsed.pkcs7.get());
    describe_signer(parsed.pkcs7.get(), form);
    describe_embedded(parsed.pkcs7.get(), form);
    add_signer_certificates(parsed.pkcs7.get(), form);
  }
  take_text_header(form);
  if (form.wrapping == DocumentWrapping::multipart) {
    form.first_line = first_line_in(as_text(file), as_text(form.unverified_text));
    const auto parts = split_multipart_signed(as_text(file));
    if (!parts) form.ambiguous = parts.error();
  }
  take_openssl_reason();
  return form;
}

Status verify_as_stock_products(BytesView file, const std::vector<Certificate>& cas, WallTime now) {
  return verify_with_store(file, store_of(cas, now));
}

Status verify_as_stock_products(BytesView file, BytesView ca_file, std::size_t count,
                                WallTime now) {
  if (ca_file.size() > kMaxBundleOctets) return fail(Code::certificate_too_large);
  const auto store = store_of(ca_file, count, now);
  return store ? verify_with_store(file, store) : fail(Code::certificate_malformed);
}

std::optional<AnnouncedCa> ca_announced_by_fastdds(BytesView ca_file) {
  const BioPtr in = bio_over(ca_file);
  std::optional<AnnouncedCa> out;
  while (in && (!out || out->algorithm.empty())) {
    const X509Ptr ca(PEM_read_bio_X509_AUX(in.get(), nullptr, nullptr, nullptr));
    if (!ca) break;
    const OpensslTextPtr name(X509_NAME_oneline(X509_get_subject_name(ca.get()), nullptr, 0));
    if (!out) out = AnnouncedCa{.name = name ? name.get() : "", .algorithm = {}};
    out->algorithm = algorithm_for_fastdds(ca.get());
  }
  take_openssl_reason();  // the error at the end of the file
  return out;
}

}  // namespace ddssec::pki
