// What the tests of access control share: documents made and signed on the spot, and a plugin with
// a clock that a test moves.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/documents_in_use.hpp"
#include "base/plugin_services.hpp"
#include "governance/write.hpp"
#include "pki/authority.hpp"
#include "plugins/access_control/access_control.hpp"
#include "plugins/access_control/documents.hpp"
#include "plugins/spi/property_names.hpp"
#include "plugins/spi/session_facts.hpp"
#include "tests/support/recorded_events.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::access_control {

using namespace std::chrono_literals;
using pki::kNow;
using pki::test_random;

inline constexpr const char* kTalker = "CN=talker,O=Example";
inline constexpr const char* kListener = "CN=listener,O=Example";
inline constexpr spi::IdentityHandle kLocalIdentity{1};
inline constexpr spi::IdentityHandle kRemoteIdentity{2};

/// A governance document with one rule for domains 0 to 230 and one rule for every topic.
inline governance::Governance protected_governance() {
  governance::DomainRule rule;
  rule.domains.ranges = {{0, 230}};
  rule.topic_rules.push_back({.topic_expression = "*"});
  return {.domain_rules = {rule}};
}

inline governance::Criteria topics(std::vector<std::string> names) {
  governance::Criteria criteria;
  for (auto& name : names) criteria.topics.push_back({std::move(name), 0});
  return criteria;
}

/// Returns a rule for domains 0 to 230.
inline governance::GrantRule rule(bool allow) {
  governance::GrantRule out;
  out.allow = allow;
  out.domains.ranges = {{0, 230}};
  return out;
}

inline governance::GrantRule publish_rule(bool allow, std::vector<std::string> names) {
  auto out = rule(allow);
  out.publish = {topics(std::move(names))};
  return out;
}

inline governance::GrantRule subscribe_rule(bool allow, std::vector<std::string> names) {
  auto out = rule(allow);
  out.subscribe = {topics(std::move(names))};
  return out;
}

inline governance::Grant grant(std::string subject, std::vector<governance::GrantRule> rules) {
  governance::Grant out;
  out.name = "test";
  out.subject_name = std::move(subject);
  out.validity = {kNow - 24h, kNow + 24h};
  out.rules = std::move(rules);
  return out;
}

inline std::string data_uri(BytesView octets) { return "data:," + std::string(as_text(octets)); }

/// The authorities and identities of the tests. Their keys are made once for all tests.
struct Authorities {
  pki::Authority identity_ca = pki::make_ca("CN=Identity CA,O=Example");
  pki::Authority permissions_ca = pki::make_ca("CN=Permissions CA,O=Example");
  pki::Authority other_ca = pki::make_ca("CN=Permissions CA,O=Example");
  pki::Credential talker = pki::make_leaf(identity_ca, kTalker);
  pki::Credential listener = pki::make_leaf(identity_ca, kListener);
  static const Authorities& shared() {
    static const Authorities authorities;
    return authorities;
  }
};

class AccessControlTest : public testing::Test {
 protected:
  const Authorities& authorities() const { return Authorities::shared(); }

  std::string signed_by(const pki::Authority& ca, const std::string& xml) const {
    auto file = ca.sign_document(as_bytes(xml), signing_time, test_random());
    EXPECT_TRUE(file) << file.error().to_sentence();
    return std::string(as_text(*file));
  }
  std::string signed_document(const std::string& xml) const {
    return signed_by(authorities().permissions_ca, xml);
  }
  std::string signed_permissions(std::vector<governance::Grant> grants) const {
    return signed_document(
        governance::to_xml(governance::Permissions{.grants = std::move(grants)}));
  }
  /// Returns permissions to publish and subscribe to everything.
  std::string open_permissions(const char* subject) const {
    auto all = rule(true);
    all.publish = {topics({"*"})};
    all.subscribe = {topics({"*"})};
    return signed_permissions({grant(subject, {all})});
  }

  spi::PropertyList properties(const std::string& governance_file,
                               const std::string& permissions_file) const {
    return {{std::string(spi::property::kIdentityCertificate),
             "data:," + authorities().talker.certificate.pem()},
            {std::string(spi::property::kPermissionsCa),
             "data:," + authorities().permissions_ca.certificate().pem()},
            {std::string(spi::property::kGovernance), "data:," + governance_file},
            {std::string(spi::property::kPermissions), "data:," + permissions_file},
            {std::string(spi::property::kIdentityCa),
             "data:," + authorities().identity_ca.certificate().pem()}};
  }

  void make(AccessControlOptions options = {}) {
    plugin = make_access_control(services, std::move(options));
  }

  /// Makes a local participant of the talker in domain 0.
  Result<spi::PermissionsHandle> local(const std::string& permissions_file) {
    return local(governance_document, permissions_file);
  }
  Result<spi::PermissionsHandle> local(const governance::Governance& content,
                                       const std::string& permissions_file) {
    return plugin->validate_local_permissions(
        kLocalIdentity, 0,
        properties(signed_document(governance::to_xml(content)), permissions_file));
  }

  spi::Token permissions_token() const { return {.class_id = "DDS:Access:Permissions:1.0"}; }
  spi::Token credential(const pki::Credential& peer, const std::string& permissions_file) const {
    return {.class_id = "DDS:Auth:PKI-DH:1.0",
            .properties = {{"c.id", peer.certificate.pem()}, {"c.perm", permissions_file}}};
  }
  /// Makes the listener a peer of the local participant.
  Result<spi::PermissionsHandle> remote(const std::string& permissions_file,
                                        const spi::SessionFacts& facts = {}) {
    auto token = credential(authorities().listener, permissions_file);
    spi::add_session_facts(token, facts);
    return plugin->validate_remote_permissions(kLocalIdentity, kRemoteIdentity, permissions_token(),
                                               token);
  }

  /// As a host does every few seconds. Returns whose permissions have ended.
  std::vector<spi::PermissionsHandle> poll(std::chrono::seconds after = 5s) {
    clock.advance(after);
    return plugin->poll();
  }
  /// As often as a host would in a quarter of a minute. Returns the events of that time.
  std::vector<Code> codes_after_looking() {
    log.all.clear();
    for (int i = 0; i < 3; ++i) poll();
    return log.codes();
  }

  WallTime signing_time = kNow;  ///< of what is signed next
  ManualClock clock{kNow};
  SystemRandom random;
  test::RecordedEvents log;
  DocumentsInUse documents;
  PluginServices services{clock, random, log, &documents};
  std::unique_ptr<spi::AccessControl> plugin = make_access_control(services);
  governance::Governance governance_document = protected_governance();
};

/// Expects that the call is refused with the code, and that one event says so.
#define EXPECT_REFUSED(call, expected_code)     \
  do {                                          \
    log.all.clear();                            \
    EXPECT_CODE(call, expected_code);           \
    EXPECT_EQ(log.only(), Code::expected_code); \
  } while (false)

}  // namespace ddssec::access_control
