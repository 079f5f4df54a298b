// Signed documents that others made: Cyclone DDS, SROS2, NIST, BoringSSL.
#include <filesystem>
#include <sstream>

#include "pki/smime.hpp"
#include "tests/support/test_data.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::pki {
namespace {

std::vector<Certificate> ca_file(const std::string& name) {
  auto cas = Certificate::bundle_from_pem(data_file(name));
  EXPECT_TRUE(cas) << name << ": " << cas.error().to_sentence();
  return *std::move(cas);
}

DocumentVerifier verifier(const std::string& ca) { return *DocumentVerifier::make(ca_file(ca)); }

struct CycloneRow {
  std::string file;
  bool signature_ok;
  std::string ca;  // "-" if none of the CAs here fits
};

std::vector<CycloneRow> cyclone_rows() {
  const auto table = data_file("cyclonedds/expected-openssl.tsv");
  std::istringstream lines{std::string(as_text(table))};
  std::vector<CycloneRow> rows;
  std::string line;
  std::getline(lines, line);  // heading
  while (std::getline(lines, line)) {
    std::istringstream columns(line);
    std::string file, ok, ca;
    std::getline(columns, file, '\t');
    std::getline(columns, ok, '\t');
    std::getline(columns, ca, '\t');
    rows.push_back({"cyclonedds/" + file, ok == "yes", ca});
  }
  return rows;
}

// Returns the CA file of that name beside the document, or the common one if the folder has none.
std::string ca_beside(const CycloneRow& row) {
  const auto folder = row.file.substr(0, row.file.rfind('/') + 1);
  const bool there = std::filesystem::exists(test::data_path(folder + row.ca));
  return there ? folder + row.ca : "cyclonedds/validate_local_permissions/Test_Permissions_ca.pem";
}

TEST(CycloneDocuments, EachDocument_HasTheVerdictThatOpensslGave) {
  const auto rows = cyclone_rows();
  EXPECT_EQ(rows.size(), 46u);
  int accepted = 0;
  for (const auto& row : rows) {
    const auto ca = row.ca == "-" ? CycloneRow{row.file, false, "Test_Permissions_ca.pem"} : row;
    const auto document = verifier(ca_beside(ca)).verify(data_file(row.file), kNow);
    EXPECT_EQ(document.has_value(), row.signature_ok && row.ca != "-")
        << row.file << (document ? "" : ": " + document.error().to_sentence());
    if (!document) continue;
    ++accepted;
    EXPECT_NE(as_text(document->content()).find("<dds"), std::string_view::npos);
    EXPECT_FALSE(as_text(document->content()).starts_with("Content-Type"));
  }
  EXPECT_EQ(accepted, 40);
}

TEST(CycloneDocuments, RefusedDocuments_SayWhy) {
  const std::string folder = "cyclonedds/validate_local_permissions/";
  const auto v = verifier(folder + "Test_Permissions_ca.pem");
  EXPECT_CODE(v.verify(data_file(folder + "Test_Permissions_not_signed.p7s"), kNow),
              smime_not_multipart);
  EXPECT_CODE(v.verify(data_file(folder + "Test_Governance_not_signed.p7s"), kNow),
              smime_not_multipart);
  EXPECT_CODE(v.verify(data_file(folder + "Test_Governance_unknown_ca.p7s"), kNow),
              smime_signer_not_permissions_ca);
  EXPECT_CODE(v.verify(data_file(folder + "Test_Permissions_unknown_ca.p7s"), kNow),
              smime_signer_not_permissions_ca);
}

TEST(CycloneDocuments, AnotherCa_AcceptsNone) {
  const auto other = make_ca("CN=Somebody else");
  const auto v = *DocumentVerifier::make({other.certificate()});
  const auto rows = cyclone_rows();
  EXPECT_EQ(rows.size(), 46u);
  for (const auto& row : rows) EXPECT_FALSE(v.verify(data_file(row.file), kNow)) << row.file;
}

TEST(StockSros2Documents, GoodAndBadDocuments_AreToldApart) {
  const std::string base = "sros2/generated/";
  const auto v = verifier(base + "keystore/public/ca.cert.pem");
  const auto check = [&](const std::string& name) {
    return v.verify(data_file(base + name), kNow);
  };
  EXPECT_TRUE(check("keystore/enclaves/governance.p7s"));
  EXPECT_TRUE(check("keystore/enclaves/talker_listener/talker/permissions.p7s"));
  // The signatures are good. The dates and the subject inside are checked by access control.
  EXPECT_TRUE(check("negative/permissions.expired.p7s"));
  EXPECT_TRUE(check("negative/permissions.other_subject.p7s"));
  EXPECT_CODE(check("negative/permissions.tampered.p7s"), smime_signature_invalid);
  EXPECT_CODE(check("negative/permissions.wrong_ca.p7s"), smime_signer_not_permissions_ca);
  EXPECT_CODE(check("negative/permissions.opaque.p7s"), smime_not_multipart);
  EXPECT_CODE(check("negative/permissions.no_text.p7s"), smime_content_type);
}

TEST(Sros2Identities, ChainAndRevocation_AreJudged) {
  const std::string base = "sros2/generated/";
  const auto cas = ca_file(base + "keystore/public/ca.cert.pem");
  const auto enclave = base + "keystore/enclaves/talker_listener/";
  const auto talker = *Certificate::from_pem(data_file(enclave + "talker/cert.pem"));
  const auto listener = *Certificate::from_pem(data_file(enclave + "listener/cert.pem"));
  EXPECT_EQ(talker.subject(), "CN=/talker_listener/talker");
  const auto crls = *Crl::all_from(data_file(base + "negative/crl.listener_revoked.pem"));
  const auto v = make_verifier(cas, crls);
  const auto at = crls.front().this_update() + 1s;
  const auto good = v.verify(talker, at);
  EXPECT_TRUE(good) << good.error().to_sentence();
  EXPECT_CODE(v.verify(listener, at), certificate_revoked);
  EXPECT_TRUE(make_verifier(cas).verify(listener, at));
}

TEST(BoringsslSignatures, SignatureOfALeaf_IsParsedAndRefusedForItsSigner) {
  // The signer is an end-entity certificate, so it cannot be in a CA file at all.
  const auto leaf = Certificate::bundle_from_pem(data_file("boringssl/pkcs7/sign_cert.pem"));
  ASSERT_TRUE(leaf) << leaf.error().to_sentence();
  const auto ca = make_ca();
  const auto v = *DocumentVerifier::make({ca.certificate()});
  const std::string shell =
      std::string(as_text(*ca.sign_document(as_bytes("test"), kNow, test_random())));
  const auto begin = shell.find("smime.p7s\"\n\n") + 12;
  for (const char* name : {"sign_sha1.p7s", "sign_sha1_key_id.p7s", "sign_sha256.p7s",
                           "sign_sha256_key_id.p7s", "sign_sha256_cert2.p7s"}) {
    const auto der = data_file(std::string("boringssl/pkcs7/") + name);
    const auto file =
        shell.substr(0, begin) + base64(der) + "\n" + shell.substr(shell.find("\n--", begin));
    const auto verdict = v.verify(as_bytes(file), kNow);
    ASSERT_FALSE(verdict);
    EXPECT_EQ(verdict.error().code(), std::string_view(name).find("sha1") != std::string_view::npos
                                          ? Code::smime_digest_too_weak
                                          : Code::smime_signer_not_permissions_ca)
        << name << verdict.error().to_sentence();
  }
}

}  // namespace
}  // namespace ddssec::pki
