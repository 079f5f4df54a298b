// Attacks on permissions and governance: forged, exchanged, outdated and hostile documents (T1 to
// T10 in docs/attacks.md).
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <gmock/gmock.h>

#include "tests/support/code_of.hpp"
#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

using pki::data_file;
using pki::replaced;
using test::code_of;

class ForgedDocuments : public AccessControlTest {
 protected:
  void SetUp() override {
    ASSERT_TRUE(local(open_permissions(kTalker)));
    log.all.clear();
  }

  // Signs with openssl and a certificate and key that the attacker has.
  std::string signed_with_openssl(const std::string& xml, const pki::Certificate& certificate,
                                  const pki::PrivateKey& key) const {
    const auto folder = std::filesystem::temp_directory_path() /
                        ("ddssec_attack_" + certificate.serial() + std::to_string(getpid()));
    std::filesystem::create_directory(folder);
    std::ofstream(folder / "doc.xml") << xml;
    std::ofstream(folder / "cert.pem") << certificate.pem();
    const auto pem = key.to_pem();
    EXPECT_TRUE(pem);
    pem->expose([&](BytesView octets) { std::ofstream(folder / "key.pem") << as_text(octets); });
    const std::string in = folder.string() + "/";
    EXPECT_EQ(std::system(("openssl smime -sign -text -in " + in + "doc.xml -out " + in +
                           "doc.p7s -signer " + in + "cert.pem -inkey " + in + "key.pem")
                              .c_str()),
              0);
    std::ifstream file(folder / "doc.p7s", std::ios::binary);
    const std::string out(std::istreambuf_iterator<char>(file), {});
    std::filesystem::remove_all(folder);
    return out;
  }

  std::string open_xml(const char* subject) const {
    return governance::to_xml(
        governance::Permissions{.grants = {grant(subject, {publish_rule(true, {"*"})})}});
  }
  std::string governance_xml() const { return governance::to_xml(protected_governance()); }
};

// T1, CVE-2023-24011: one CA for identities and permissions, and permissions that a leaf signed.
TEST_F(ForgedDocuments, PermissionsSignedByALeafOfTheSameCa_AreRefused) {
  const auto& ca = authorities().permissions_ca;
  const auto insider = pki::make_leaf(ca, kListener);
  const auto file = signed_with_openssl(open_xml(kListener), insider.certificate, insider.key);
  EXPECT_REFUSED(
      plugin->validate_remote_permissions(kLocalIdentity, kRemoteIdentity, permissions_token(),
                                          credential(insider, file)),
      smime_signer_not_permissions_ca);
  auto list = properties(signed_document(governance_xml()), file);
  list[0].value = "data:," + insider.certificate.pem();
  EXPECT_REFUSED(plugin->validate_local_permissions(kLocalIdentity, 0, list),
                 smime_signer_not_permissions_ca);
}

TEST_F(ForgedDocuments, PermissionsSignedByALeafWithTheCaFlag_AreRefused) {
  auto& ca = authorities().permissions_ca;
  const auto key = pki::PrivateKey::generate(pki::KeyKind::ec_p256);
  ASSERT_TRUE(key);
  const auto certificate = ca.certify({.subject = kListener,
                                       .validity = pki::kYear,
                                       .is_ca = true,
                                       .key_usage = std::string(pki::kCaKeyUsage)},
                                      *key, test_random());
  ASSERT_TRUE(certificate);
  const auto file = signed_with_openssl(open_xml(kListener), *certificate, *key);
  EXPECT_REFUSED(remote(file), smime_signer_not_permissions_ca);
}

TEST_F(ForgedDocuments, DocumentsSignedByAnUnlistedSubordinateCa_AreRefused) {
  const auto sub =
      authorities().permissions_ca.subordinate("CN=Sub CA", {}, pki::kYear, test_random());
  ASSERT_TRUE(sub);
  const auto file = signed_by(*sub, open_xml(kListener));
  EXPECT_REFUSED(remote(file), smime_signer_not_permissions_ca);
  // If the subordinate CA is in the permissions CA file, its documents are accepted.
  auto list = properties(signed_by(*sub, governance_xml()), signed_by(*sub, open_xml(kTalker)));
  list[1].value += sub->certificate().pem();
  EXPECT_TRUE(plugin->validate_local_permissions(kLocalIdentity, 0, list));
  EXPECT_TRUE(remote(file));
}

// T10: documents that were signed by others.
TEST_F(ForgedDocuments, GovernanceByOthers_IsRefused) {
  const auto with_governance = [&](const std::string& file) {
    return plugin->validate_local_permissions(kLocalIdentity, 0,
                                              properties(file, open_permissions(kTalker)));
  };
  const auto& leaf = authorities().talker;
  EXPECT_REFUSED(with_governance(signed_with_openssl(governance_xml(), leaf.certificate, leaf.key)),
                 smime_signer_not_permissions_ca);
  EXPECT_REFUSED(with_governance(signed_by(authorities().other_ca, governance_xml())),
                 smime_signer_not_permissions_ca);
  EXPECT_REFUSED(with_governance(governance_xml()), smime_not_multipart);
  const auto once = signed_document(governance_xml());
  const auto twice = signed_document(once);
  EXPECT_REFUSED(with_governance(twice), xml_not_well_formed);
  EXPECT_REFUSED(with_governance(replaced(once, "ENCRYPT", "SIGN   ")), smime_signature_invalid);
  EXPECT_REFUSED(with_governance("x\n" + once), smime_not_multipart);
  EXPECT_REFUSED(with_governance(once + "<dds/>"), smime_surrounding_text);
}

// T2: an expired CA is accepted.
TEST_F(ForgedDocuments, ExpiredAndFuturePermissionsCa_AreRefused) {
  for (const auto& [validity, code] :
       {std::pair{pki::Validity{kNow - 48h, kNow - 1h}, Code::certificate_expired},
        std::pair{pki::Validity{kNow + 1h, kNow + 48h}, Code::certificate_not_yet_valid}}) {
    const auto ca = pki::make_ca("CN=Old CA", {}, validity);
    auto list = properties(signed_by(ca, governance_xml()), signed_by(ca, open_xml(kTalker)));
    list[1].value = "data:," + ca.certificate().pem();
    log.all.clear();
    const auto result = plugin->validate_local_permissions(kLocalIdentity, 0, list);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code(), code);
    EXPECT_EQ(log.only(), code);
  }
}

// T5: a topic whose name has a wildcard does not match the names that the wildcard would match.
TEST_F(ForgedDocuments, WildcardsInNames_OpenNothing) {
  auto narrow = grant(kListener, {publish_rule(true, {"Square", "s?"})});
  const auto peer = remote(signed_permissions({narrow}));
  ASSERT_TRUE(peer);
  for (const auto* name : {"*", "Squar?", "S*", "[S]quare", "Square*"}) {
    EXPECT_REFUSED(plugin->check_remote_datawriter(*peer, 0, {.topic_name = name}),
                   announced_writer_not_allowed);
  }
  const std::vector<std::string_view> wild = {"*"};
  EXPECT_REFUSED(
      plugin->check_remote_datawriter(*peer, 0, {.topic_name = "Square", .partitions = wild}),
      announced_writer_not_allowed);
}

// T7: a signed document may still be hostile.
TEST_F(ForgedDocuments, HostileXml_IsRefusedThoughSigned) {
  const auto xml = open_xml(kListener);
  std::string deep;
  for (int i = 0; i < 52'000; ++i) deep += "<a>";
  const std::pair<std::string, Code> cases[] = {
      {"<!DOCTYPE dds [<!ENTITY a \"x\">]>" + xml.substr(xml.find("<dds>")), Code::xml_doctype},
      {replaced(xml, "<topic>*", "<topic>&all;"), Code::xml_entity},
      {replaced(xml, "<dds>", "<?x y?><dds>"), Code::xml_processing_instruction},
      {replaced(xml, "UTF-8", "UTF-16"), Code::xml_encoding},
      {replaced(xml, "<topic>*", "<topic>\xFF"), Code::xml_encoding},
      {replaced(xml, "<dds>", deep + "<dds>"), Code::xml_too_deep},
      {replaced(xml, "<topic>*</topic>", "<topic/>"), Code::element_empty},
      {replaced(xml, "<topic>*</topic>", ""), Code::element_missing},
      {replaced(xml, "<default>DENY</default>", "<default>DENY</default><default>ALLOW</default>"),
       Code::element_repeated},
      {replaced(xml, "<default>DENY</default>", "<default/>"), Code::element_empty},
      {xml + "<dds/>", Code::xml_not_well_formed},
      {"", Code::xml_not_well_formed}};
  for (const auto& [text, code] : cases) {
    log.all.clear();
    const auto result = remote(signed_document(text));
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code(), code) << result.error().to_sentence();
    EXPECT_EQ(log.only(), code);
  }
}

// T8: the document of another participant, and a document that has ended. A former document of the
// same subject counts until it ends.
TEST_F(ForgedDocuments, PermissionsOfOthersAndOldOnes_AreRefused) {
  EXPECT_REFUSED(remote(open_permissions(kTalker)), no_grant_for_subject);
  auto all = rule(true);
  all.publish = {topics({"*"})};
  auto ended = grant(kListener, {all});
  ended.validity = {kNow - 24h, kNow};
  const auto old = signed_permissions({ended});
  EXPECT_REFUSED(remote(old), grant_expired);
  // Even one octet that was changed after signing is noticed.
  EXPECT_REFUSED(remote(replaced(old, "<topic>*", "<topic>+")), smime_signature_invalid);
  EXPECT_REFUSED(remote(old + "x"), smime_surrounding_text);
}

// T9: a flipped bit in a token or document changes no accepted content. One bit is tried in every
// third octet of a document, because each takes the time of a verification.
TEST_F(ForgedDocuments, FlippedBits_NeverWidenTheRights) {
  const auto file = open_permissions(kListener);
  const std::string_view content(file.data() + file.find("<dds>"),
                                 file.rfind("</dds>") - file.find("<dds>"));
  const auto begin = static_cast<std::size_t>(content.data() - file.data());
  for (std::size_t at = begin; at < begin + content.size(); at += 3) {
    auto changed = file;
    changed[at] = static_cast<char>(changed[at] ^ (1 << at % 8));
    log.all.clear();
    EXPECT_THAT(code_of(remote(changed)), testing::AnyOf(Code::smime_signature_invalid,
                                                         Code::smime_malformed, Code::smime_nul))
        << at;
  }
  const std::string good = "DDS:Access:Permissions:1.0";
  for (std::size_t at = 0; at < 24; ++at) {
    auto changed = good;
    changed[at] = static_cast<char>(changed[at] ^ 1);
    EXPECT_EQ(code_of(plugin->validate_remote_permissions(
                  kLocalIdentity, kRemoteIdentity, {.class_id = changed},
                  credential(authorities().listener, file))),
              Code::permissions_token_class)
        << changed;
  }
}

TEST_F(ForgedDocuments, EveryPartOfADocument_IsRefused) {
  const auto file = open_permissions(kListener);
  ASSERT_OK(remote(file));
  for (std::size_t size = 0; size + 8 < file.size(); size += 1) {
    EXPECT_FALSE(remote(file.substr(0, size))) << size;
  }
  const auto& pem = authorities().listener.certificate.pem();
  for (std::size_t size = 0; size + 2 < pem.size(); size += 1) {
    const spi::Token cut{.properties = {{"c.id", pem.substr(0, size)}, {"c.perm", file}}};
    EXPECT_FALSE(plugin->validate_remote_permissions(kLocalIdentity, kRemoteIdentity,
                                                     permissions_token(), cut))
        << size;
  }
}

// A document of another project, and the code with which it is refused, if it is.
struct Verdict {
  const char* file;
  std::optional<Code> code;
};
void PrintTo(const Verdict& verdict, std::ostream* out) { *out << verdict.file; }

class CycloneDocuments : public AccessControlTest, public testing::WithParamInterface<Verdict> {
 protected:
  std::string file(const std::string& name) const {
    return std::string(as_text(data_file("cyclonedds/" + name)));
  }
  spi::PropertyList cyclone_properties(const std::string& governance_file,
                                       const std::string& permissions_file) const {
    auto list = properties(file(governance_file), file(permissions_file));
    list[0].value = "data:," + file("validate_local_identity/identity_certificate");
    list[1].value = "data:," + file("validate_local_permissions/Test_Permissions_ca.pem");
    return list;
  }
  void expect_verdict(const Result<spi::PermissionsHandle>& result) {
    if (!GetParam().code) {
      EXPECT_TRUE(result) << result.error().to_sentence();
    } else {
      ASSERT_FALSE(result);
      EXPECT_EQ(result.error().code(), *GetParam().code) << result.error().to_sentence();
      EXPECT_EQ(log.only(), *GetParam().code);
    }
  }
};

class CycloneGovernance : public CycloneDocuments {};
TEST_P(CycloneGovernance, EachVendorFile_IsJudgedAsExpected) {
  expect_verdict(plugin->validate_local_permissions(
      kLocalIdentity, 0,
      cyclone_properties(GetParam().file, "validate_local_permissions/Test_Permissions_ok.p7s")));
}
INSTANTIATE_TEST_SUITE_P(
    Files, CycloneGovernance,
    testing::Values(
        Verdict{"validate_local_permissions/Test_Governance_ok.p7s", {}},
        Verdict{"validate_local_permissions/Test_Governance_full.p7s", {}},
        Verdict{"validate_local_permissions/Test_Governance_check_create_participant.p7s",
                Code::domain_not_covered},
        Verdict{"validate_local_permissions/Test_Governance_invalid_data.p7s",
                Code::value_not_protection_kind},
        Verdict{"validate_local_permissions/Test_Governance_invalid_element.p7s",
                Code::element_unknown},
        Verdict{"validate_local_permissions/Test_Governance_not_signed.p7s",
                Code::smime_not_multipart},
        Verdict{"validate_local_permissions/Test_Governance_unknown_ca.p7s",
                Code::smime_signer_not_permissions_ca},
        Verdict{"get_xxx_sec_attributes/Test_Governance_full.p7s", {}},
        Verdict{"get_xxx_sec_attributes/Test_Governance_liveliness_discovery_clear.p7s", {}},
        Verdict{"get_xxx_sec_attributes/Test_Governance_liveliness_discovery_different.p7s", {}},
        Verdict{"get_xxx_sec_attributes/Test_Governance_liveliness_discovery_encrypted.p7s", {}},
        Verdict{"get_xxx_sec_attributes/"
                "Test_Governance_liveliness_discovery_encrypted_and_authenticated.p7s",
                {}},
        Verdict{"get_xxx_sec_attributes/Test_Governance_liveliness_discovery_signed.p7s", {}},
        Verdict{"get_xxx_sec_attributes/"
                "Test_Governance_liveliness_discovery_signed_and_authenticated.p7s",
                {}}));

class CyclonePermissions : public CycloneDocuments {};
TEST_P(CyclonePermissions, OwnVendorFiles_AreJudgedAsExpected) {
  expect_verdict(plugin->validate_local_permissions(
      kLocalIdentity, 0,
      cyclone_properties("validate_local_permissions/Test_Governance_ok.p7s", GetParam().file)));
}
TEST_P(CyclonePermissions, PeersVendorFiles_AreJudgedAsExpected) {
  ASSERT_TRUE(plugin->validate_local_permissions(
      kLocalIdentity, 0,
      cyclone_properties("validate_local_permissions/Test_Governance_ok.p7s",
                         "validate_local_permissions/Test_Permissions_ok.p7s")));
  const spi::Token peer{
      .properties = {{"c.id", file("validate_local_identity/identity_certificate")},
                     {"c.perm", file(GetParam().file)}}};
  expect_verdict(plugin->validate_remote_permissions(kLocalIdentity, kRemoteIdentity,
                                                     permissions_token(), peer));
}
INSTANTIATE_TEST_SUITE_P(
    Files, CyclonePermissions,
    testing::Values(
        Verdict{"validate_local_permissions/Test_Permissions_ok.p7s", {}},
        Verdict{"validate_local_permissions/Test_Permissions_full.p7s", {}},
        Verdict{"validate_local_permissions/Test_Permissions_expired.p7s", Code::grant_expired},
        Verdict{"validate_local_permissions/Test_Permissions_notyet.p7s",
                Code::grant_not_yet_valid},
        Verdict{"validate_local_permissions/Test_Permissions_invalid_data.p7s",
                Code::value_not_domain_id},
        Verdict{"validate_local_permissions/Test_Permissions_invalid_element.p7s",
                Code::element_unknown},
        Verdict{"validate_local_permissions/Test_Permissions_lack_of_not_after.p7s",
                Code::element_missing},
        Verdict{"validate_local_permissions/Test_Permissions_lack_of_not_before.p7s",
                Code::element_missing},
        Verdict{"validate_local_permissions/Test_Permissions_not_signed.p7s",
                Code::smime_not_multipart},
        Verdict{"validate_local_permissions/Test_Permissions_unknown_ca.p7s",
                Code::smime_signer_not_permissions_ca},
        Verdict{"validate_local_permissions/Test_Permissions_unknown_subject.p7s",
                Code::no_grant_for_subject},
        Verdict{"validate_remote_permissions/Test_Permissions_ok.p7s", {}},
        // Its RDNs are in neither of the two orders. Cyclone DDS accepts any order.
        Verdict{"validate_remote_permissions/Test_Permissions_different_subject_representation.p7s",
                Code::no_grant_for_subject},
        Verdict{"validate_remote_permissions/Test_Permissions_missing_subject_component.p7s",
                Code::no_grant_for_subject},
        Verdict{"validate_remote_permissions/Test_Permissions_not_signed.p7s",
                Code::smime_not_multipart},
        Verdict{"validate_remote_permissions/Test_Permissions_unknown_subject.p7s",
                Code::no_grant_for_subject}));

class Sros2Documents : public AccessControlTest, public testing::WithParamInterface<Verdict> {
 protected:
  static std::string file(const std::string& name) {
    return std::string(as_text(data_file("sros2/generated/" + name)));
  }
};
TEST_P(Sros2Documents, EachGeneratedFile_IsJudgedAsExpected) {
  const std::string enclave = "keystore/enclaves/talker_listener/talker/";
  auto list = properties(file("keystore/enclaves/governance.p7s"), file(GetParam().file));
  list[0].value = "data:," + file(enclave + "cert.pem");
  list[1].value = "data:," + file("keystore/public/ca.cert.pem");
  const auto handle = plugin->validate_local_permissions(kLocalIdentity, 0, list);
  if (GetParam().code) {
    ASSERT_FALSE(handle);
    EXPECT_EQ(handle.error().code(), *GetParam().code) << handle.error().to_sentence();
    EXPECT_EQ(log.only(), *GetParam().code);
    return;
  }
  ASSERT_TRUE(handle) << handle.error().to_sentence();
  EXPECT_TRUE(plugin->check_create_participant(*handle, 0));
  EXPECT_TRUE(plugin->check_create_datawriter(*handle, 0, {.topic_name = "rt/chatter"}));
  EXPECT_REFUSED(plugin->check_create_datareader(*handle, 0, {.topic_name = "rt/chatter"}),
                 subscribe_not_allowed);
}
INSTANTIATE_TEST_SUITE_P(
    Files, Sros2Documents,
    testing::Values(Verdict{"keystore/enclaves/talker_listener/talker/permissions.p7s", {}},
                    Verdict{"negative/permissions.tampered.p7s", Code::smime_signature_invalid},
                    Verdict{"negative/permissions.wrong_ca.p7s",
                            Code::smime_signer_not_permissions_ca},
                    Verdict{"negative/permissions.expired.p7s", Code::grant_expired},
                    Verdict{"negative/permissions.other_subject.p7s", Code::no_grant_for_subject},
                    Verdict{"negative/permissions.opaque.p7s", Code::smime_not_multipart},
                    Verdict{"negative/permissions.no_text.p7s", Code::smime_content_type}));

}  // namespace
}  // namespace ddssec::access_control
