#include "tests/unit/access_control/access_control_fixture.hpp"

namespace ddssec::access_control {
namespace {

using LocalPermissions = AccessControlTest;

TEST_F(LocalPermissions, ValidDocuments_AreAcceptedAndHandedOn) {
  const auto document = open_permissions(kTalker);
  const auto handle = local(document);
  ASSERT_TRUE(handle) << handle.error().to_sentence();
  EXPECT_TRUE(*handle);
  const auto token = plugin->permissions_token(*handle);
  ASSERT_TRUE(token);
  EXPECT_EQ(token->class_id, "DDS:Access:Permissions:1.0");
  EXPECT_TRUE(token->properties.empty());
  const auto credential_token = plugin->permissions_credential_token(*handle);
  ASSERT_TRUE(credential_token);
  EXPECT_EQ(credential_token->class_id, "DDS:Access:PermissionsCredential");
  ASSERT_EQ(credential_token->properties.size(), 1u);
  EXPECT_EQ(credential_token->properties[0].name, "dds.perm.cert");
  EXPECT_EQ(credential_token->properties[0].value, document);
  EXPECT_TRUE(log.all.empty());
}

// Cyclone DDS passes documents on as texts that end with a NUL.
TEST_F(LocalPermissions, NulAtTheEndOfTheFile_IsNotHandedOn) {
  const auto document = open_permissions(kTalker);
  const auto handle = local(document + '\0');
  ASSERT_TRUE(handle) << handle.error().to_sentence();
  const auto token = plugin->permissions_credential_token(*handle);
  ASSERT_TRUE(token);
  EXPECT_EQ(token->properties[0].value, document);
}

TEST_F(LocalPermissions, OtherOrderOfTheSubject_IsTheSameSubject) {
  EXPECT_TRUE(local(open_permissions("O=Example, CN=talker")));
}

TEST_F(LocalPermissions, LongerThanPeersAreSent_AreRefusedByTheirName) {
  std::vector<governance::GrantRule> rules = {rule(true)};
  std::string long_name(1000, 'x');
  rules[0].publish = {topics(std::vector<std::string>(1050, long_name))};
  const auto result = local(signed_permissions({grant(kTalker, rules)}));
  EXPECT_CODE(result, file_too_large);
  EXPECT_EQ(result.error().details().document, spi::property::kPermissions);
  EXPECT_EQ(result.error().details().expected, "at most 1048576 octets, since peers are sent it");
  EXPECT_EQ(log.only(), Code::file_too_large);
}

TEST_F(LocalPermissions, NothingConfigured_IsRefused) {
  EXPECT_REFUSED(plugin->validate_local_permissions(kLocalIdentity, 0, {}), access_not_configured);
}

TEST_F(LocalPermissions, MissingDocument_IsNamed) {
  for (const auto property :
       {spi::property::kPermissionsCa, spi::property::kGovernance, spi::property::kPermissions}) {
    auto list = properties("x", "y");
    std::erase_if(list, [&](const auto& p) { return p.name == property; });
    log.all.clear();
    const auto result = plugin->validate_local_permissions(kLocalIdentity, 0, list);
    EXPECT_CODE(result, access_document_missing);
    EXPECT_EQ(result.error().details().expected, property);
  }
}

TEST_F(LocalPermissions, EmptyProperty_IsAMissingOne) {
  auto list = properties("x", "y");
  list[2].value.clear();
  EXPECT_REFUSED(plugin->validate_local_permissions(kLocalIdentity, 0, list),
                 access_document_missing);
}

TEST_F(LocalPermissions, MissingCertificate_IsRefused) {
  auto list = properties("x", "y");
  list.erase(list.begin());
  EXPECT_REFUSED(plugin->validate_local_permissions(kLocalIdentity, 0, list), missing_property);
}

TEST_F(LocalPermissions, FileThatDoesNotExist_IsNamed) {
  auto list = properties("x", "y");
  list[1].value = "file:does_not_exist.pem";
  EXPECT_REFUSED(plugin->validate_local_permissions(kLocalIdentity, 0, list), file_not_found);
}

TEST_F(LocalPermissions, UnsignedGovernance_IsRefused) {
  const auto list =
      properties(governance::to_xml(protected_governance()), open_permissions(kTalker));
  EXPECT_REFUSED(plugin->validate_local_permissions(kLocalIdentity, 0, list), smime_not_multipart);
}

TEST_F(LocalPermissions, DocumentOfAnotherSubject_IsRefusedWithBothNames) {
  log.all.clear();
  const auto result = local(open_permissions(kListener));
  EXPECT_CODE(result, no_grant_for_subject);
  EXPECT_EQ(result.error().details().expected, kTalker);
  EXPECT_EQ(result.error().details().found, kListener);
  EXPECT_EQ(result.error().details().document, "dds.sec.access.permissions");
  EXPECT_EQ(log.only(), Code::no_grant_for_subject);
}

TEST_F(LocalPermissions, ExchangedDocuments_AreNamed) {
  const auto list = properties(open_permissions(kTalker),
                               signed_document(governance::to_xml(protected_governance())));
  EXPECT_REFUSED(plugin->validate_local_permissions(kLocalIdentity, 0, list), document_kind);
}

TEST_F(LocalPermissions, DomainWithoutRule_IsRefused) {
  auto content = protected_governance();
  content.domain_rules[0].domains.ranges = {{1, 230}};
  EXPECT_REFUSED(local(content, open_permissions(kTalker)), domain_not_covered);
}

TEST_F(LocalPermissions, ExpiredAndFutureGrants_AreRefused) {
  const auto document = open_permissions(kTalker);
  clock.set(kNow + 24h);
  EXPECT_REFUSED(local(document), grant_expired);
  clock.set(kNow - 24h - 1s);
  // The permissions CA itself is not valid before that time either.
  EXPECT_REFUSED(local(document), certificate_not_yet_valid);
  auto late = grant(kTalker, {rule(true)});
  late.validity = {kNow + 1s, kNow + 24h};
  clock.set(kNow);
  EXPECT_REFUSED(local(signed_permissions({late})), grant_not_yet_valid);
}

TEST_F(LocalPermissions, AnotherGrantOfTheSubject_MayBeValid) {
  auto old = grant(kTalker, {rule(true)});
  old.validity = {kNow - 24h, kNow - 1h};
  EXPECT_TRUE(local(signed_permissions({old, grant(kTalker, {rule(true)})})));
}

TEST_F(LocalPermissions, UnsupportedProtection_IsNotSilentlyLeftOut) {
  auto content = protected_governance();
  content.domain_rules[0].rtps_psk_protection_kind = ProtectionKind::sign;
  EXPECT_REFUSED(local(content, open_permissions(kTalker)), governance_not_enforceable);
  content = protected_governance();
  content.domain_rules[0].enable_key_revision = true;
  EXPECT_REFUSED(local(content, open_permissions(kTalker)), governance_not_enforceable);
  make({.host_revises_keys = true});
  const auto handle = local(content, open_permissions(kTalker));
  ASSERT_TRUE(handle) << handle.error().to_sentence();
  EXPECT_TRUE(plugin->participant_sec_attributes(*handle)->is_key_revision_enabled);
}

TEST_F(LocalPermissions, PreSharedKeys_AreForHostsThatHaveThem) {
  make({.host_has_pre_shared_keys = true});
  auto content = protected_governance();
  content.domain_rules[0].rtps_psk_protection_kind = ProtectionKind::encrypt;
  const auto handle = local(content, open_permissions(kTalker));
  ASSERT_TRUE(handle) << handle.error().to_sentence();
  EXPECT_EQ(plugin->participant_sec_attributes(*handle)->rtps_psk, ProtectionKind::encrypt);
}

TEST_F(LocalPermissions, CipherList_MustHoldAllThatAreUsed) {
  auto content = protected_governance();
  auto& allowed = content.domain_rules[0].allowed_algorithms.emplace();
  allowed.digital_signature = {{"RSASSA-PSS-MGF1SHA256+2048+SHA256", 0}, {"ECDSA+P256+SHA256", 0}};
  allowed.key_establishment = {{"DHE+MODP-2048-256", 0}, {"ECDHE-CEUM+P256", 0}};
  allowed.symmetric_cipher = {{"AES256+GCM", 0}, {"AES128+GCM", 0}};
  EXPECT_TRUE(local(content, open_permissions(kTalker)));
  allowed.symmetric_cipher.pop_back();
  EXPECT_REFUSED(local(content, open_permissions(kTalker)), governance_not_enforceable);
}

using RemotePermissions = AccessControlTest;

TEST_F(RemotePermissions, TextAndBinaryCredentials_AreAccepted) {
  ASSERT_TRUE(local(open_permissions(kTalker)));
  const auto document = open_permissions(kListener);
  EXPECT_TRUE(remote(document));
  const auto& pem = authorities().listener.certificate.pem();
  spi::Token binary{.class_id = "DDS:Auth:PKI-DH:1.0",
                    .binary_properties = {{"c.id", to_bytes(as_bytes(pem))},
                                          {"c.perm", to_bytes(as_bytes(document))}}};
  for (auto& property : binary.binary_properties) property.value.push_back(0);
  EXPECT_TRUE(plugin->validate_remote_permissions(kLocalIdentity, kRemoteIdentity,
                                                  permissions_token(), binary));
  EXPECT_TRUE(log.all.empty());
}

TEST_F(RemotePermissions, PermissionsWithoutALocalParticipant_AreRefused) {
  EXPECT_REFUSED(remote(open_permissions(kListener)), unknown_local_identity);
}

TEST_F(RemotePermissions, MissingPermissions_AreRefused) {
  ASSERT_TRUE(local(open_permissions(kTalker)));
  EXPECT_REFUSED(remote(""), permissions_missing);
}

TEST_F(RemotePermissions, MissingPeerCertificate_IsRefused) {
  ASSERT_TRUE(local(open_permissions(kTalker)));
  EXPECT_REFUSED(plugin->validate_remote_permissions(
                     kLocalIdentity, kRemoteIdentity, permissions_token(),
                     {.properties = {{"c.perm", open_permissions(kListener)}}}),
                 peer_certificate_missing);
}

TEST_F(RemotePermissions, OversizedPermissions_AreRefused) {
  make({.max_permissions_octets = 100});
  ASSERT_TRUE(local(open_permissions(kTalker)));
  EXPECT_REFUSED(remote(open_permissions(kListener)), permissions_too_large);
}

TEST_F(RemotePermissions, RefusalEvent_NamesThePeer) {
  ASSERT_TRUE(local(open_permissions(kTalker)));
  EXPECT_CODE(remote(open_permissions(kTalker)), no_grant_for_subject);
  ASSERT_EQ(log.all.size(), 1u);
  EXPECT_EQ(log.all[0].peer_subject, kListener);
  EXPECT_EQ(log.all[0].error.details().document, std::string("permissions of ") + kListener);
}

TEST_F(RemotePermissions, TokenClass_IsComparedByNameAndMajorVersion) {
  ASSERT_TRUE(local(open_permissions(kTalker)));
  const auto peer = credential(authorities().listener, open_permissions(kListener));
  for (const auto* good :
       {"DDS:Access:Permissions:1.0", "DDS:Access:Permissions:1.2", "dds:access:PERMISSIONS:1.7",
        "DDS:Access:Permissions", "DDS:Access:Permissions:1"}) {
    EXPECT_TRUE(plugin->validate_remote_permissions(kLocalIdentity, kRemoteIdentity,
                                                    {.class_id = good}, peer))
        << good;
  }
  for (const auto* bad : {"", "DDS:Access:Permissions:2.0", "DDS:Access:Permissions:10.0",
                          "DDS:Access:Other:1.0", "DDS:Access:Permission"}) {
    EXPECT_REFUSED(plugin->validate_remote_permissions(kLocalIdentity, kRemoteIdentity,
                                                       {.class_id = bad}, peer),
                   permissions_token_class);
  }
}

// Where joining is free, a peer without permissions gets a handle, and access to open topics only.
TEST_F(RemotePermissions, FreeJoining_NeedsNoPermissions) {
  governance_document.domain_rules[0].enable_join_access_control = false;
  auto& rules = governance_document.domain_rules[0].topic_rules;
  rules.insert(rules.begin(), {.topic_expression = "open",
                               .enable_read_access_control = false,
                               .enable_write_access_control = false});
  ASSERT_TRUE(local(open_permissions(kTalker)));
  log.all.clear();
  const auto peer = remote("");
  ASSERT_TRUE(peer);
  EXPECT_EQ(log.only(), Code::permissions_missing);
  EXPECT_TRUE(plugin->check_remote_participant(*peer, 0));
  EXPECT_TRUE(plugin->check_remote_datawriter(*peer, 0, {.topic_name = "open"}));
  EXPECT_TRUE(plugin->check_remote_topic(*peer, 0, "open"));
  EXPECT_REFUSED(plugin->check_remote_datawriter(*peer, 0, {.topic_name = "closed"}),
                 peer_has_no_permissions);
  EXPECT_REFUSED(plugin->check_remote_datareader(*peer, 0, {.topic_name = "closed"}),
                 peer_has_no_permissions);
  EXPECT_REFUSED(plugin->check_remote_topic(*peer, 0, "closed"), peer_has_no_permissions);
}

// Each participant is judged by the documents of the local participant that it meets, also if
// several of them are in one process.
TEST_F(RemotePermissions, EachLocalParticipant_JudgesByItsOwnCa) {
  ASSERT_TRUE(local(open_permissions(kTalker)));
  auto list =
      properties(signed_by(authorities().other_ca, governance::to_xml(governance_document)),
                 signed_by(authorities().other_ca, governance::to_xml(governance::Permissions{
                                                       .grants = {grant(kTalker, {rule(true)})}})));
  list[1].value = "data:," + authorities().other_ca.certificate().pem();
  constexpr spi::IdentityHandle kSecond{7};
  ASSERT_TRUE(plugin->validate_local_permissions(kSecond, 0, list));
  const auto peer = credential(authorities().listener, open_permissions(kListener));
  EXPECT_TRUE(plugin->validate_remote_permissions(kLocalIdentity, kRemoteIdentity,
                                                  permissions_token(), peer));
  EXPECT_REFUSED(
      plugin->validate_remote_permissions(kSecond, kRemoteIdentity, permissions_token(), peer),
      smime_signer_not_permissions_ca);
}

// The open governance of one local participant lets no peer in at the other one, whichever leaves
// first.
TEST_F(RemotePermissions, EachLocalParticipant_JudgesByItsOwnGovernance) {
  auto open = governance_document;
  for (auto& domain : open.domain_rules) {
    domain.enable_join_access_control = false;
    for (auto& topic : domain.topic_rules)
      topic.enable_read_access_control = topic.enable_write_access_control = false;
  }
  constexpr spi::IdentityHandle kSecond{7};
  const auto reader_only = signed_permissions({grant(kListener, {subscribe_rule(true, {"t"})})});
  for (const bool strict_leaves_first : {false, true}) {
    make();
    ASSERT_TRUE(local(open_permissions(kTalker)));
    ASSERT_TRUE(plugin->validate_local_permissions(
        kSecond, 0,
        properties(signed_document(governance::to_xml(open)), open_permissions(kTalker))));
    const auto strict = remote(reader_only);
    const auto lenient =
        plugin->validate_remote_permissions(kSecond, kRemoteIdentity, permissions_token(),
                                            credential(authorities().listener, reader_only));
    ASSERT_TRUE(strict && lenient);
    const auto expect_strict = [&] {
      EXPECT_REFUSED(plugin->check_remote_datawriter(*strict, 0, {.topic_name = "t"}),
                     announced_writer_not_allowed);
    };
    const auto expect_lenient = [&] {
      EXPECT_TRUE(plugin->check_remote_datawriter(*lenient, 0, {.topic_name = "t"}));
    };
    expect_strict(), expect_lenient();
    EXPECT_TRUE(plugin->return_permissions_handle(strict_leaves_first ? *strict : *lenient));
    strict_leaves_first ? expect_lenient() : expect_strict();
  }
}

}  // namespace
}  // namespace ddssec::access_control
