// The domain tag of an embedded participant selects the rules of its documents.
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

/// ENCRYPT for the tag "secure", NONE for the empty tag.
spi::PropertyList two_rules() {
  governance::Governance content;
  for (const auto kind : {ProtectionKind::encrypt, ProtectionKind::none}) {
    auto rule = Rules{.rtps = kind, .discovery = kind}.document().domain_rules[0];
    rule.domains.tag_expressions.clear();
    if (is_protected(kind)) rule.domains.tags = {{"secure", 0}};
    content.domain_rules.push_back(rule);
  }
  auto properties = properties_of("CN=a", {});
  for (auto& property : properties)
    if (property.name == spi::property::kGovernance)
      property.value = data_uri(as_text(*Authorities::shared().permissions_ca.sign_document(
          as_bytes(governance::to_xml(content)), pki::kNow, pki::test_random())));
  return properties;
}

TEST(DomainTag, SelectsTheGovernanceRuleOfAnEmbeddedParticipant) {
  Node host(1, member("host", {}));
  const auto own = [&](std::string_view tag) {
    return OwnSecurity::create(
        {{*host.authentication, *host.access_control, *host.cryptography}, two_rules()}, 0,
        Node::candidate(2), tag);
  };
  const auto secure = own("secure"), empty = own(""), other = own("other");
  ASSERT_TRUE(secure && empty);
  EXPECT_EQ((*secure)->attributes().rtps, ProtectionKind::encrypt);
  EXPECT_EQ((*secure)->attributes().discovery, ProtectionKind::encrypt);
  EXPECT_EQ((*empty)->attributes().rtps, ProtectionKind::none);
  ASSERT_FALSE(other);
  EXPECT_EQ(other.error().code(), Code::domain_not_covered);
}

}  // namespace
}  // namespace ddssec::rtps
