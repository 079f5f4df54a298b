// NIST PKITS without its policy tests, as S/MIME messages. Each message contains its certificates,
// which stand for a configured CA file here.
#include <filesystem>
#include <set>
#include <sstream>

#include "pki/mime.hpp"
#include "pki/openssl.hpp"
#include "tests/support/test_data.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

struct Message {
  std::vector<Certificate> cas;
  std::optional<Certificate> end_entity;
  std::optional<Error> refused;  // set if a certificate does not even parse by our rules
};

Certificate anchor() {
  return *Certificate::from_der(data_file("nist-pkits/certs/TrustAnchorRootCertificate.crt"));
}

Bytes decode(std::string_view base64_text) {
  std::string text;
  for (char c : base64_text)
    if (c != '\n' && c != '\r') text += c;
  Bytes out(text.size());
  const int size =
      EVP_DecodeBlock(out.data(), as_bytes(text).data(), static_cast<int>(text.size()));
  out.resize(static_cast<std::size_t>(size > 0 ? size : 0));
  return out;
}

Message read(const std::string& name) {
  const auto file = data_file("nist-pkits/smime/" + name);
  const auto parts = split_multipart_signed(as_text(file));
  EXPECT_TRUE(parts) << name;
  const auto der = decode(parts->signature);
  const auto* position = der.data();
  const CmsPtr cms(d2i_CMS_ContentInfo(nullptr, &position, static_cast<long>(der.size())));
  auto* signer = sk_CMS_SignerInfo_value(CMS_get0_SignerInfos(cms.get()), 0);
  auto* list = CMS_get1_certs(cms.get());
  Message message;
  for (int i = 0; i < sk_X509_num(list); ++i) {
    X509* x509 = sk_X509_value(list, i);
    unsigned char* raw = nullptr;
    const int size = i2d_X509(x509, &raw);
    const OpensslMemoryPtr owner(raw);
    auto certificate = Certificate::from_der(BytesView(raw, static_cast<std::size_t>(size)));
    if (!certificate)
      message.refused = certificate.error();
    else if (CMS_SignerInfo_cert_cmp(signer, x509) == 0)
      message.end_entity = *certificate;
    else
      message.cas.push_back(*certificate);
  }
  sk_X509_pop_free(list, X509_free);
  return message;
}

std::vector<Crl> all_crls() {
  std::vector<Crl> out;
  for (const auto& entry :
       std::filesystem::directory_iterator(test::data_path("nist-pkits/crls"))) {
    const auto crls =
        Crl::all_from(data_file("nist-pkits/crls/" + entry.path().filename().string()));
    if (crls) out.insert(out.end(), crls->begin(), crls->end());
  }
  return out;
}

// Returns the code of the refusal; empty if the message is accepted.
std::string verdict(const Message& message, const std::vector<Crl>& crls) {
  if (message.refused) return std::string(info(message.refused->code()).name);
  auto cas = message.cas;
  cas.push_back(anchor());
  const auto verifier = ChainVerifier::make(std::move(cas), crls);
  if (!verifier) return std::string(info(verifier.error().code()).name);
  const auto proof = verifier->verify(*message.end_entity, kNow);
  return proof ? "" : std::string(info(proof.error().code()).name);
}

// True if we accept the message. The rules differ from `openssl smime -verify -crl_check_all`.
bool expected(const std::string& name, bool openssl) {
  if (name == "SignedValidDSASignaturesTest4.eml") return false;  // DSA keys are not allowed
  // Delta lists are refused when they are read, so only the complete list decides. It does not have
  // the certificate of test 4 yet, still has that of test 5, and is out of date in test 10.
  if (name == "SignedInvaliddeltaCRLTest4.eml") return true;
  if (name == "SignedValiddeltaCRLTest5.eml" || name == "SignedInvaliddeltaCRLTest10.eml")
    return false;
  return openssl;
}

TEST(Pkits, EveryDeltaList_IsRefusedAndNoCompleteOne) {
  std::set<std::string> refused;
  for (const auto& entry :
       std::filesystem::directory_iterator(test::data_path("nist-pkits/crls"))) {
    const auto name = entry.path().filename().string();
    const auto crls = Crl::all_from(data_file("nist-pkits/crls/" + name));
    if (!crls && crls.error().code() == Code::crl_is_delta) refused.insert(name);
  }
  EXPECT_EQ(refused,
            (std::set<std::string>{"deltaCRLCA1deltaCRL.crl", "deltaCRLCA2deltaCRL.crl",
                                   "deltaCRLCA3deltaCRL.crl", "deltaCRLIndicatorNoBaseCACRL.crl"}));
}

TEST(Pkits, Verdicts_AreThoseOfOpensslWithRevocationLists) {
  const auto crls = all_crls();
  EXPECT_GE(crls.size(), 160u);
  const auto table = data_file("nist-pkits/smime-expected.tsv");
  std::istringstream lines{std::string(as_text(table))};
  std::string line;
  std::set<std::string> reasons;
  int accepted = 0, refused = 0;
  while (std::getline(lines, line)) {
    std::istringstream columns(line);
    std::string name, by_name, without_crl, with_crl;
    std::getline(columns, name, '\t');
    std::getline(columns, by_name, '\t');
    std::getline(columns, without_crl, '\t');
    std::getline(columns, with_crl, '\t');
    if (!std::filesystem::exists(test::data_path("nist-pkits/smime/" + name))) continue;
    const auto reason = verdict(read(name), crls);
    EXPECT_EQ(reason.empty(), expected(name, with_crl == "ok")) << name << ": " << reason;
    (reason.empty() ? accepted : refused) += 1;
    if (!reason.empty()) reasons.insert(reason);
  }
  EXPECT_GE(accepted, 20);
  EXPECT_GE(refused, 30);
  for (const char* reason : {"certificate_not_yet_valid", "certificate_signature_invalid",
                             "certificate_revoked", "not_a_ca", "path_too_long", "issuer_unknown"})
    EXPECT_TRUE(reasons.contains(reason)) << reason;
}

}  // namespace
}  // namespace ddssec::pki
