// The domain tag of an embedded participant selects the rules of its documents.
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// Returns properties with ENCRYPT for the tag "secure" and NONE for the empty tag.
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

TEST(DomainTag, EmbeddedParticipant_IsUnderTheGovernanceRuleOfItsTag) {
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

// Makes a participant with a tag, in a domain, with the plugins of `host`.
std::unique_ptr<Node> tagged(std::uint8_t n, Node& host, const std::string& subject,
                             const std::string& tag, DomainId domain = 0) {
  auto node = std::make_unique<Node>(n);
  auto own = OwnSecurity::create({{*host.authentication, *host.access_control, *host.cryptography},
                                  properties_of(subject, everything(ProtectionKind::encrypt))},
                                 domain, Node::candidate(n), tag);
  EXPECT_TRUE(own) << own.error().to_sentence();
  auto config = Node::config(n, (*own)->guid().prefix);
  config.domain_tag = tag;
  config.domain_id = domain;
  node->participant = std::make_unique<RtpsParticipant>(config, node->post, node->events);
  EXPECT_TRUE(node->participant->enable_security(std::move(*own)));
  return node;
}

bool is_announcement(BytesView datagram) {
  auto reader = MessageReader::open(datagram);
  while (const auto view = *reader->next())
    if (view->id == SubmessageId::data && read_data(*view)->writer == kSpdpWriter) return true;
  return false;
}

// Changes the tag in an announcement to the other one.
Bytes with_other_tag(Bytes datagram) {
  if (!is_announcement(datagram)) return datagram;
  for (auto at = datagram.begin(); at + 5 < datagram.end(); ++at)
    if (std::equal(at, at + 4, "tag-")) at[4] = at[4] == 'a' ? 'b' : 'a';
  return datagram;
}

// Otherwise an attacker on the path could connect participants of two domains.
TEST(DomainTag, AnnouncedTag_IsNotBelievedAndTheProvenOneCounts) {
  for (const bool same : {true, false}) {
    Node alices(3, member("host-a", {})), bobs(4, member("host-b", {}));
    const auto a = tagged(1, alices, "CN=alice,O=Example", "tag-a");
    const auto b = tagged(2, bobs, "CN=bob,O=Example", same ? "tag-a" : "tag-b");
    World world{{a.get(), b.get()}};
    if (!same)
      world.filter = [](const Node&, Bytes datagram) {
        return one(with_other_tag(std::move(datagram)));
      };
    const auto met = [&] { return a->knows(*b) || b->knows(*a); };
    EXPECT_EQ(world.run_until(met, 1500), same);
    const auto told = [](const Node& node) { return node.events.has(Code::rtps_domain_differs); };
    EXPECT_EQ(told(alices) || told(bobs), !same);  // the plugins refuse the other tag
  }
}

// Changes the domain id in an announcement to the other one, 0 or 1.
Bytes with_other_domain(Bytes datagram) {
  if (!is_announcement(datagram)) return datagram;
  constexpr std::array<std::uint8_t, 4> kDomainId{0x0f, 0, 4, 0};  // PID_DOMAIN_ID and its length
  const auto at = std::ranges::search(datagram, kDomainId);
  if (!at.empty() && at.end() != datagram.end()) *at.end() ^= 1;
  return datagram;
}

TEST(DomainTag, AnnouncedDomainId_IsNotBelievedAndTheProvenOneCounts) {
  for (const bool same : {true, false}) {
    Node alices(3, member("host-a", {})), bobs(4, member("host-b", {}));
    const auto a = tagged(1, alices, "CN=alice,O=Example", "");
    const auto b = tagged(2, bobs, "CN=bob,O=Example", "", same ? 0 : 1);
    World world{{a.get(), b.get()}};
    if (!same)
      world.filter = [](const Node&, Bytes datagram) {
        return one(with_other_domain(std::move(datagram)));
      };
    const auto met = [&] { return a->knows(*b) || b->knows(*a); };
    EXPECT_EQ(world.run_until(met, 1500), same);
    const auto told = [](const Node& node) { return node.events.has(Code::rtps_domain_differs); };
    EXPECT_EQ(told(alices) || told(bobs), !same);
  }
}

}  // namespace
}  // namespace ddssec::rtps
