// <allowed_crypto_algorithms>: whose keys and which handshakes a governance document refuses.
#include "plugins/access_control/allowed_algorithms.hpp"

#include <map>
#include <string>
#include <tuple>

#include "tests/support/temporary_folder.hpp"
#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

using governance::AllowedAlgorithms;
using governance::Text;
using pki::KeyKind;
using pki::KeySpec;

constexpr KeySpec kP256{KeyKind::ec_p256}, kP384{KeyKind::ec_p384};
constexpr KeySpec kRsa2048{KeyKind::rsa, 2048}, kRsa3072{KeyKind::rsa, 3072};
constexpr const char* kRsa = "RSASSA-PSS-MGF1SHA256+2048+SHA256";
constexpr const char* kEc = "ECDSA+P256+SHA256";
constexpr const char* kEc384 = "ECDSA+P384+SHA384";
constexpr const char* kEcdhe = "ECDHE-CEUM+P256";
constexpr const char* kEcdhe384 = "ECDHE-CEUM+P384";
constexpr const char* kDhe = "DHE+MODP-2048-256";

std::vector<Text> list(std::initializer_list<const char*> names) {
  std::vector<Text> out;
  for (const auto* name : names) out.push_back({name, 0});
  return out;
}

// Participants whose certificates and CAs have keys of any kind.
class ListedAlgorithms : public AccessControlTest {
 protected:
  struct Party {
    explicit Party(KeySpec key, KeySpec ca_key, const char* subject = kTalker)
        : ca(pki::make_ca("CN=Identity CA,O=Example", ca_key)),
          own(pki::make_leaf(ca, subject, key)) {}
    pki::Authority ca;
    pki::Credential own;
  };
  // Made once for all tests of the process: an RSA key takes long.
  static const Party& party(KeySpec key, KeySpec ca_key, const char* subject = kTalker) {
    static std::map<std::tuple<KeyKind, int, KeyKind, int, std::string>, Party> made;
    const auto name = std::tuple(key.kind, key.bits, ca_key.kind, ca_key.bits, subject);
    return made.try_emplace(name, key, ca_key, subject).first->second;
  }

  Result<spi::PermissionsHandle> local_of(const Party& party, const pki::Certificate& authority) {
    auto content = protected_governance();
    content.domain_rules[0].allowed_algorithms = allowed;
    content.domain_rules[0].enable_join_access_control = join;
    auto all = properties(signed_document(governance::to_xml(content)), open_permissions(kTalker));
    all[0].value = "data:," + party.own.certificate.pem();
    all.back().value = "data:," + authority.pem();
    return plugin->validate_local_permissions(kLocalIdentity, 0, all);
  }
  Result<spi::PermissionsHandle> local_of(const Party& party) {
    return local_of(party, party.ca.certificate());
  }
  // Hands the certificate over as our authentication does after a handshake.
  Result<spi::PermissionsHandle> remote_of(const pki::Certificate& certificate,
                                           const char* key_establishment = kEcdhe) {
    spi::Token credential{
        .class_id = "DDS:Auth:PKI-DH:1.0",
        .properties = {{"c.id", certificate.pem()}, {"c.perm", open_permissions(kListener)}}};
    if (key_establishment != nullptr)
      credential.properties.push_back({"c.kagree_algo", key_establishment});
    return plugin->validate_remote_permissions(kLocalIdentity, kRemoteIdentity, permissions_token(),
                                               credential);
  }

  AllowedAlgorithms allowed{.digital_signature = list({kRsa, kEc}),
                            .key_establishment = list({kDhe, kEcdhe}),
                            .symmetric_cipher = list({"AES128+GCM", "AES256+GCM"})};
  bool join = true;
};

TEST_F(ListedAlgorithms, OwnKey_MustBeListed) {
  EXPECT_TRUE(local_of(party(kP256, kP256)));
  EXPECT_TRUE(local_of(party(kRsa2048, kP256)));
  EXPECT_REFUSED(local_of(party(kP384, kP256)), identity_algorithm_not_allowed);
  const auto refused = local_of(party(kRsa3072, kP256));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code(), Code::identity_algorithm_not_allowed);
  const auto& details = refused.error().details();
  EXPECT_EQ(details.field, "<digital_signature>");
  EXPECT_EQ(details.expected, std::string(kRsa) + ", " + kEc);
  EXPECT_EQ(details.found, std::string("RSASSA-PSS-MGF1SHA256+3072+SHA256 of ") + kTalker);
  EXPECT_FALSE(details.document.empty());
  allowed.digital_signature = list({kEc384});
  allowed.digital_signature_identity_trust_chain = list({kEc});
  EXPECT_TRUE(local_of(party(kP384, kP256)));
  EXPECT_REFUSED(local_of(party(kP256, kP256)), identity_algorithm_not_allowed);
  allowed.digital_signature = list({"RSASSA-PSS-MGF1SHA256+3072+SHA256"});
  EXPECT_TRUE(local_of(party(kRsa3072, kP256)));
}

TEST_F(ListedAlgorithms, NamesOfVersion11_CountToo) {
  allowed.digital_signature = list({"RSASSA-PSS-SHA256"});
  allowed.digital_signature_identity_trust_chain = list({"EC-prime256v1"});
  EXPECT_TRUE(local_of(party(kRsa2048, kP256)));
  EXPECT_REFUSED(local_of(party(kRsa3072, kP256)), identity_algorithm_not_allowed);
  allowed.digital_signature = list({"ECDSA-SHA256"});
  EXPECT_TRUE(local_of(party(kP256, kP256)));
}

TEST_F(ListedAlgorithms, OwnAuthority_MustBeListed) {
  const auto& under_p384 = party(kP256, kP384);
  const auto& under_rsa = party(kP256, kRsa3072);
  const auto& plain = party(kP256, kP256);
  EXPECT_REFUSED(local_of(under_p384), trust_chain_algorithm_not_allowed);
  EXPECT_REFUSED(local_of(under_rsa), trust_chain_algorithm_not_allowed);
  // If the document has a list for the trust chain, only that list counts for the CA. The
  // permissions CA, which has a P-256 key, signs the documents.
  allowed.digital_signature_identity_trust_chain = list({kEc384});
  EXPECT_REFUSED(local_of(plain), trust_chain_algorithm_not_allowed);
  EXPECT_REFUSED(local_of(under_p384), trust_chain_algorithm_not_allowed);
  allowed.digital_signature_identity_trust_chain = list({kEc384, kEc});
  EXPECT_TRUE(local_of(under_p384));
  allowed.digital_signature_identity_trust_chain = list({"RSASSA-PKCS1-V1_5+3072+SHA256", kEc});
  EXPECT_TRUE(local_of(under_rsa));
}

TEST_F(ListedAlgorithms, EveryAuthorityAboveTheCertificate_Counts) {
  const auto root =
      pki::Authority::create_root("CN=Root,O=Example", kP384, pki::kYear, test_random()).value();
  const auto middle =
      root.subordinate("CN=Middle,O=Example", kP256, pki::kYear, test_random()).value();
  const auto leaf = pki::make_leaf(middle, kTalker);
  const std::string bundle = middle.certificate().pem() + root.certificate().pem();
  const auto both = pki::Certificate::bundle_from_pem(as_bytes(bundle)).value();
  EXPECT_CODE(check_identity(allowed, leaf.certificate, both), trust_chain_algorithm_not_allowed);
  EXPECT_TRUE(check_identity(allowed, leaf.certificate, {&both[0], 1}));
  allowed.digital_signature.push_back({kEc384, 0});
  EXPECT_TRUE(check_identity(allowed, leaf.certificate, both));
}

TEST_F(ListedAlgorithms, APeersKeyAndAuthority_MustBeListed) {
  const auto& own = party(kP256, kP256);
  ASSERT_TRUE(local_of(own));
  const auto of = [&](KeySpec key) { return pki::make_leaf(own.ca, kListener, key).certificate; };
  EXPECT_TRUE(remote_of(of(kP256)));
  EXPECT_TRUE(remote_of(of(kRsa2048)));
  EXPECT_REFUSED(remote_of(of(kP384)), identity_algorithm_not_allowed);
  EXPECT_REFUSED(remote_of(of(kRsa3072)), identity_algorithm_not_allowed);
  // This certificate is of a CA from trusted_ca_dir, not from identity_ca. Its keys are not known
  // here.
  const auto& other = party(kP256, kP256, kListener);
  EXPECT_REFUSED(remote_of(other.own.certificate), trust_chain_algorithm_not_allowed);
}

TEST_F(ListedAlgorithms, FreeJoining_KeepsTheDomainsAlgorithms) {
  join = false;
  const auto& own = party(kP256, kP256);
  ASSERT_TRUE(local_of(own));
  EXPECT_REFUSED(remote_of(pki::make_leaf(own.ca, kListener, kP384).certificate),
                 identity_algorithm_not_allowed);
  EXPECT_REFUSED(remote_of(own.own.certificate, kEcdhe384), key_establishment_not_allowed);
}

TEST_F(ListedAlgorithms, ThePeersHandshake_MustBeListed) {
  const auto& own = party(kP256, kP256);
  const auto peer = pki::make_leaf(own.ca, kListener).certificate;
  ASSERT_TRUE(local_of(own));
  for (const auto* name : {kEcdhe, kDhe, "ECDH+prime256v1-CEUM", "DH+MODP-2048-256"})
    EXPECT_TRUE(remote_of(peer, name)) << name;
  EXPECT_REFUSED(remote_of(peer, kEcdhe384), key_establishment_not_allowed);
  EXPECT_REFUSED(remote_of(peer, "org.example.Handshake"), key_establishment_not_allowed);
  // A stock authentication plugin does not say which algorithm it used. It can use both that are
  // listed.
  EXPECT_TRUE(remote_of(peer, nullptr));
  allowed.key_establishment = list({kEcdhe});
  ASSERT_TRUE(local_of(own));
  EXPECT_TRUE(remote_of(peer));
  EXPECT_REFUSED(remote_of(peer, "DH+MODP-2048-256"), key_establishment_not_allowed);
  EXPECT_REFUSED(remote_of(peer, nullptr), key_establishment_not_allowed);
  allowed.key_establishment = list({kEcdhe, kEcdhe384});
  ASSERT_TRUE(local_of(own));
  EXPECT_TRUE(remote_of(peer, kEcdhe384));
}

TEST_F(ListedAlgorithms, WhatOurHandshakesBeginWith_MustBeListed) {
  allowed.key_establishment = list({kEcdhe384, kDhe});
  EXPECT_REFUSED(local_of(party(kP256, kP256)), governance_not_enforceable);
}

// DDS-Security 1.2, clause 10.4.1.2.5.9: "may use any of the algorithms defined in clause 8.2".
TEST_F(ListedAlgorithms, AnAbsentList_AllowsWhatTheStandardNames) {
  allowed = {};
  const auto& own = party(kP256, kP256);
  EXPECT_TRUE(local_of(party(kP384, kRsa2048)));
  EXPECT_REFUSED(local_of(party(kRsa3072, kP256)), identity_algorithm_not_allowed);
  EXPECT_REFUSED(local_of(party(kP256, kRsa3072)), trust_chain_algorithm_not_allowed);
  ASSERT_TRUE(local_of(own));
  const auto peer = pki::make_leaf(own.ca, kListener).certificate;
  for (const auto* name : {kEcdhe, kEcdhe384, kDhe}) EXPECT_TRUE(remote_of(peer, name)) << name;
  EXPECT_REFUSED(remote_of(peer, "org.example.Handshake"), key_establishment_not_allowed);
  // The other lists count nevertheless.
  allowed.digital_signature = list({kEc});
  EXPECT_REFUSED(local_of(party(kP384, kP256)), identity_algorithm_not_allowed);
}

TEST_F(ListedAlgorithms, NoAlgorithmElement_AllowsAll) {
  auto content = protected_governance();
  const auto& own = party(kP384, kRsa3072);
  auto all = properties(signed_document(governance::to_xml(content)), open_permissions(kTalker));
  all[0].value = "data:," + own.own.certificate.pem();
  EXPECT_TRUE(plugin->validate_local_permissions(kLocalIdentity, 0, all));
}

// The identity CAs are in a file, which a test replaces.
class AlgorithmsOfLaterCas : public ListedAlgorithms {
 protected:
  Result<spi::PermissionsHandle> local_with_file() {
    auto content = protected_governance();
    content.domain_rules[0].allowed_algorithms = allowed;
    auto all = properties(signed_document(governance::to_xml(content)), open_permissions(kTalker));
    all[0].value = "data:," + own_.own.certificate.pem();
    all.back().value = "file:" + folder_.write("identity_ca.pem", own_.ca.certificate().pem());
    return plugin->validate_local_permissions(kLocalIdentity, 0, all);
  }
  void put(const std::string& text) {
    folder_.replace("identity_ca.pem", text);
    clock.advance(5s);
    plugin->poll();
  }

  const test::TemporaryFolder folder_;
  const Party own_{kP256, kP256};
};

TEST_F(AlgorithmsOfLaterCas, CaThatCameLater_IsJudgedByItsKey) {
  ASSERT_TRUE(local_with_file());
  const auto& rsa = party(kP256, kRsa2048, kListener);
  const auto& p384 = party(kP256, kP384, kListener);
  EXPECT_REFUSED(remote_of(rsa.own.certificate), trust_chain_algorithm_not_allowed);
  put(own_.ca.certificate().pem() + rsa.ca.certificate().pem() + p384.ca.certificate().pem());
  EXPECT_TRUE(remote_of(rsa.own.certificate));
  EXPECT_REFUSED(remote_of(p384.own.certificate), trust_chain_algorithm_not_allowed);
}

// Authentication keeps the former CAs, too, and reports the file.
TEST_F(AlgorithmsOfLaterCas, FileThatCannotBeUsed_ChangesNothing) {
  ASSERT_TRUE(local_with_file());
  const auto& other = party(kP256, kP256, kListener);
  log.all.clear();
  put("nonsense");
  put(other.ca.certificate().pem());
  EXPECT_TRUE(log.all.empty());
  const auto peer = pki::make_leaf(own_.ca, kListener);
  EXPECT_TRUE(remote_of(peer.certificate));
}

}  // namespace
}  // namespace ddssec::access_control
