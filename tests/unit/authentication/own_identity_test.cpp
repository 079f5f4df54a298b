// Local identities: the documents that the properties name must exist, fit together and be trusted.
#include "plugins/authentication/own_identity.hpp"

#include <gmock/gmock.h>

#include "tests/support/test_data.hpp"
#include "tests/unit/authentication/authentication_fixture.hpp"
#include "tests/unit/authentication/local_identities.hpp"

namespace ddssec::authentication::local_identities {
namespace {

Identity alice() { return make_identity(test_ca(), "CN=alice,O=Example"); }

TEST(OwnIdentity, Guid_IsBoundToTheSubject) {
  TestPlugin plugin;
  const auto identity = alice();
  const auto local = create(identity.properties, plugin);
  ASSERT_OK(local);
  EXPECT_EQ(local->adjusted_guid,
            adjusted_guid(identity.certificate.subject_digest(), candidate(1)));
  EXPECT_EQ(local->adjusted_guid.entity, kEntityIdParticipant);
  EXPECT_EQ(plugin->identity_token(local->handle)->properties[0].value, "/O=Example/CN=alice");
  EXPECT_EQ(plugin->identity_status_token(local->handle)->class_id, "DDS:Auth:PKI-DH:1.0");
  EXPECT_EQ(plugin->next_expiry(), kYear.not_after);
}

// ---- certificate authorities

TEST(OwnIdentity, SubordinateCa_IsTakenAloneAndInABundle) {
  const auto root = make_ca("CN=Root");
  const auto sub = root.subordinate("CN=Sub", {}, kYear, test_random()).value();
  const auto identity = make_identity(sub, "CN=alice");
  EXPECT_TRUE(create(identity.properties));
  auto bundle = identity.properties;
  set(bundle, property::kIdentityCa, "data:," + root.certificate().pem() + sub.certificate().pem());
  TestPlugin plugin;
  const auto local = create(bundle, plugin);
  ASSERT_OK(local);
  EXPECT_EQ(plugin->identity_token(local->handle)->properties[2].value, "/CN=Sub");
  auto root_only = identity.properties;
  set(root_only, property::kIdentityCa, "data:," + root.certificate().pem());
  expect_refused(root_only, Code::issuer_unknown, property::kIdentityCertificate);
}

TEST(OwnIdentity, PeersUnderDifferentCasOfOneBundle_Meet) {
  const auto first = make_ca("CN=First"), second = make_ca("CN=Second");
  const auto bundle = "data:," + first.certificate().pem() + second.certificate().pem();
  auto a = make_identity(first, "CN=alice"), b = make_identity(second, "CN=bob", {}, kYear, 1);
  for (auto* identity : {&a, &b}) set(identity->properties, property::kIdentityCa, bundle);
  Pairing(a, b).expect_success();
}

// ---- permissions

TEST(Permissions, InvalidPermissionsTokens_AreRefusedWithTheirCodes) {
  TestPlugin plugin;
  const auto local = create(alice().properties, plugin);
  const auto give = [&](const Token& token) {
    return plugin->set_permissions_credential_and_token(local->handle, token, {});
  };
  const Token good{"DDS:Access:PermissionsCredential", {{"dds.perm.cert", "x"}}};
  EXPECT_TRUE(give(good));
  EXPECT_CODE(give({"DDS:Access:PermissionsCredential"}), permissions_credential_wrong);
  EXPECT_CODE(give({"DDS:Access:Permissions:1.0", good.properties}), permissions_credential_wrong);
  EXPECT_CODE(give({good.class_id, {{"dds.perm.cert", std::string(1024 * 1024 + 1, 'x')}}}),
              token_field_length);
  EXPECT_CODE(plugin->set_permissions_credential_and_token({99}, good, {}), unknown_identity);
}

// ---- Cyclone DDS's own test identities

std::string cyclone(const std::string& name) {
  return "file:" + test::data_path("cyclonedds/" + name);
}

PropertyList cyclone_identity(const std::string& ca, const std::string& certificate,
                              const std::string& key, const std::string& password = "") {
  const std::string folder = "validate_local_identity/";
  PropertyList properties;
  set(properties, property::kIdentityCa, cyclone(folder + ca));
  set(properties, property::kIdentityCertificate, cyclone(folder + certificate));
  set(properties, property::kPrivateKey, cyclone(folder + key));
  set(properties, property::kPassword, password);
  return properties;
}

TEST(CycloneData, GoodIdentities_AreTaken) {
  EXPECT_TRUE(create(cyclone_identity("identity_ca", "identity_certificate", "private_key")));
  EXPECT_TRUE(
      create(cyclone_identity("ec_identity_ca", "ec_identity_certificate", "ec_private_key")));
  // The certificate of this key ended in 2019.
  TestPlugin then;
  then.clock.set(std::chrono::sys_days(std::chrono::year(2019) / 1 / 1));
  EXPECT_TRUE(create(cyclone_identity("old/identity_ca", "old/identity_certificate",
                                      "private_key_w_password", "CHAM569"),
                     then));
  EXPECT_TRUE(create(cyclone_identity("ec_identity_ca", "ec_identity_certificate",
                                      "ec_private_key_w_password", "CHAM-570")));
  // This CA is a subordinate one. Stock Cyclone DDS refuses it.
  EXPECT_TRUE(
      create(cyclone_identity("Identity_CA_Test_With_Chain.crt", "Bob_Chain_Test.crt", "bob.pem")));
}

TEST(CycloneData, BadIdentities_AreRefusedWithTheirCodes) {
  expect_refused(
      cyclone_identity("identity_ca", "identity_certificate", "private_key_w_password", "CHAM568"),
      Code::passphrase_wrong, property::kPrivateKey);
  expect_refused(cyclone_identity("unrelated_identity_ca", "identity_certificate", "private_key"),
                 Code::issuer_unknown, property::kIdentityCertificate);
  expect_refused(
      cyclone_identity("identity_ca", "identity_certificate_1024key", "private_key_1024"),
      Code::key_not_allowed, property::kIdentityCertificate);
  expect_refused(cyclone_identity("ec_identity_ca", "ec_identity_certificate_unsupported",
                                  "ec_private_key_unsupported"),
                 Code::key_not_allowed, property::kIdentityCertificate);
  expect_refused(
      cyclone_identity("identity_ca", "identity_certificate", "private_key_not_matching"),
      Code::key_mismatch, property::kPrivateKey);
  expect_refused(cyclone_identity("old/identity_ca", "old/identity_certificate", "old/private_key"),
                 Code::certificate_expired, property::kIdentityCertificate);
}

TEST(CycloneData, RevocationListAndTrustedFolder_AreApplied) {
  auto properties =
      cyclone_identity("identity_ca", "revoked_identity_certificate", "revoked_private_key");
  EXPECT_TRUE(create(properties));
  set(properties, property::kCrl, cyclone("validate_local_identity/crl"));
  expect_refused(properties, Code::certificate_revoked, property::kIdentityCertificate);
  auto folder = cyclone_identity("identity_ca", "identity_certificate", "private_key");
  set(folder, property::kTrustedCaDir,
      test::data_path("cyclonedds/validate_local_identity/trusted_ca_dir"));
  EXPECT_TRUE(create(folder));
  set(folder, property::kTrustedCaDir,
      test::data_path("cyclonedds/validate_local_identity/trusted_ca_dir_not_matching"));
  expect_refused(folder, Code::own_ca_not_trusted, property::kTrustedCaDir);
}

TEST(CycloneData, ARevokedPeer_IsRefusedInTheHandshake) {
  const auto identity = [](const std::string& name, bool with_crl) {
    PropertyList properties;
    const std::string folder = "process_handshake/";
    set(properties, property::kIdentityCa, cyclone(folder + "revoker_identity_ca"));
    set(properties, property::kIdentityCertificate,
        cyclone(folder + name + "_identity_certificate"));
    set(properties, property::kPrivateKey, cyclone(folder + name + "_private_key"));
    if (with_crl) set(properties, property::kCrl, cyclone(folder + "crl"));
    return properties;
  };
  TestPlugin first(1), second(2);
  const Identity shape = alice();  // only the properties count
  // Both have the same subject, so the candidate GUIDs decide which side begins. Both orders are
  // tried.
  for (std::uint8_t number = 1; number < 20; ++number) {
    Participant watcher(first, {shape.certificate, shape.key, identity("local", true)}, number);
    Participant revoked(second, {shape.certificate, shape.key, identity("revoked", false)}, 77);
    Two two(watcher, revoked);
    const auto request = two.request();
    ASSERT_OK(request);
    const auto reply = two.reply(*request->message);
    if (&two.high == &watcher) {
      EXPECT_CODE(reply, certificate_revoked);
    } else {
      ASSERT_OK(reply);
      EXPECT_CODE(two.process_at_lower_guid(request->handle, *reply->message), certificate_revoked);
    }
    ASSERT_OK(first->return_identity_handle(watcher.handle));
  }
}

}  // namespace
}  // namespace ddssec::authentication::local_identities
