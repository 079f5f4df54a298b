// Secured participants without sockets: keys and documents that are made by the tests, a network
// that the test carries, and time that it moves.
#pragma once

#include <functional>
#include <set>

#include <gmock/gmock.h>

#include "base/plugin_services.hpp"
#include "governance/write.hpp"
#include "plugins/access_control/access_control.hpp"
#include "plugins/authentication/authentication.hpp"
#include "plugins/cryptography/cryptography.hpp"
#include "plugins/spi/property_names.hpp"
#include "rtps/participant/rtps_participant.hpp"
#include "tests/support/code_of.hpp"
#include "tests/support/recorded_events.hpp"
#include "tests/support/seeded_random.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/pki/pki_fixture.hpp"

namespace ddssec::rtps::testing {

using std::chrono::milliseconds;
using std::chrono::seconds;
using namespace std::chrono_literals;

struct Listener final : EndpointListener {
  int matched = 0, unmatched = 0;
  int alive = 0;
  int incompatible = 0;
  std::set<Guid> known;
  std::vector<Change> changes;
  void on_matched(const EndpointData& remote) override {
    matched += known.insert(remote.guid).second ? 1 : 0;
  }
  void on_unmatched(const Guid& remote) override {
    matched -= static_cast<int>(known.erase(remote));
    ++unmatched;
    signals.erase(remote);
  }
  void on_incompatible_qos(const Guid&, const QosMismatch&) override { ++incompatible; }
  void on_inconsistent_topic(const EndpointData&) override { ++incompatible; }
  bool on_change(Change& change) override {
    changes.push_back(std::move(change));
    return true;
  }
  void on_sample_lost(std::int64_t) override {}
  /// Asks to be notified of each assertion.
  void on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) override {
    signals[writer] = signal;
    if (signal) signal->notify(*this, writer);
  }
  void on_alive(const Guid& writer) override {
    ++alive;
    if (const auto& signal = signals[writer]) signal->notify(*this, writer);
  }
  std::map<Guid, std::shared_ptr<LivelinessSignal>> signals;
  void on_acknowledged() override {}
  std::shared_ptr<ChangeFilter> filter_for(const EndpointData& reader) override {
    return reader.content_filter ? filter : nullptr;
  }
  /// What a writer's owner makes of any content filter.
  std::shared_ptr<ChangeFilter> filter;
};

/// A filter with one result for all changes.
class FixedFilter final : public ChangeFilter {
 public:
  explicit FixedFilter(bool passes) : passes_(passes) {}
  std::optional<bool> passes(const Change&) override { return passes_; }

 private:
  const bool passes_;
};

/// Returns a set with any domain tag, because tests that run at the same time use different tags.
inline governance::DomainSet any_domain() {
  return {.ranges = {{0, 230}}, .tag_expressions = {{"*", 0}}};
}

/// One governance for all topics.
struct Rules {
  ProtectionKind rtps = ProtectionKind::none;
  ProtectionKind rtps_psk = ProtectionKind::none;
  ProtectionKind discovery = ProtectionKind::none;
  ProtectionKind liveliness = ProtectionKind::none;
  ProtectionKind metadata = ProtectionKind::none;
  ProtectionKind data = ProtectionKind::none;
  bool allow_unauthenticated = false;
  bool access_control = true;
  bool revises_keys = false;
  /// An expression for the partitions that the permissions allow; nullptr: only the default one.
  const char* partitions = nullptr;
  /// Discovery is protected, except that of the topics.
  bool clear_topics = false;
  /// The topics ask for protected discovery, whether any protects it or not.
  bool secure_topics = false;
  /// Topics are without access control, whatever the domain has.
  bool open_topics = false;
  bool only_aes = false;  ///< <allowed_crypto_algorithms> without ChaCha20-Poly1305

  governance::Governance document() const {
    governance::DomainRule rule;
    rule.domains = any_domain();
    rule.allow_unauthenticated_participants = allow_unauthenticated;
    rule.enable_join_access_control = access_control;
    rule.enable_key_revision = revises_keys;
    rule.rtps_protection_kind = rtps;
    rule.rtps_psk_protection_kind = rtps_psk;
    rule.discovery_protection_kind = discovery;
    rule.liveliness_protection_kind = liveliness;
    governance::TopicRule topic{.topic_expression = "*"};
    topic.enable_discovery_protection = (is_protected(discovery) || secure_topics) && !clear_topics;
    topic.enable_liveliness_protection = is_protected(liveliness);
    topic.enable_read_access_control = topic.enable_write_access_control =
        access_control && !open_topics;
    topic.metadata_protection_kind = metadata;
    topic.data_protection_kind = data;
    rule.topic_rules.push_back(topic);
    if (only_aes)
      rule.allowed_algorithms = governance::AllowedAlgorithms{
          .digital_signature = {{"RSASSA-PSS-SHA256"}, {"ECDSA-SHA256"}},
          .key_establishment = {{"DH+MODP-2048-256"}, {"ECDH+prime256v1-CEUM"}},
          .symmetric_cipher = {{"AES128+GCM"}, {"AES256+GCM"}}};
    return {.domain_rules = {rule}};
  }
};

inline constexpr Rules everything(ProtectionKind kind) {
  const bool encrypts = is_encrypted(kind);
  return {.rtps = kind,
          .discovery = kind,
          .liveliness = kind,
          .metadata = kind,
          .data = encrypts ? ProtectionKind::encrypt : ProtectionKind::sign};
}

struct Authorities {
  pki::Authority identity_ca = pki::make_ca("CN=Identity CA,O=Example");
  pki::Authority permissions_ca = pki::make_ca("CN=Permissions CA,O=Example");
  static const Authorities& shared() {
    static const Authorities authorities;
    return authorities;
  }
};

inline std::string data_uri(std::string_view text) { return "data:," + std::string(text); }

/// `topics` may be published and subscribed, for the time `valid`, with the data tags `tags`.
inline spi::PropertyList properties_of(const std::string& subject, const Rules& rules,
                                       std::vector<std::string> topics = {"*"},
                                       std::chrono::hours valid = 24h,
                                       std::optional<std::vector<governance::DataTag>> tags = {}) {
  const auto& [identity_ca, permissions_ca] = Authorities::shared();
  const auto leaf = pki::make_leaf(identity_ca, subject);
  governance::Criteria criteria;
  for (auto& name : topics) criteria.topics.push_back({std::move(name), 0});
  criteria.data_tags = std::move(tags);
  if (rules.partitions != nullptr) criteria.partitions = {{rules.partitions, 0}};
  governance::GrantRule rule;
  rule.allow = true;
  rule.domains = any_domain();
  rule.publish = {criteria};
  rule.subscribe = {criteria};
  governance::Grant grant;
  grant.name = "test";
  grant.subject_name = subject;
  grant.validity = {pki::kNow - 24h, pki::kNow + valid};
  grant.rules = {rule};
  const auto sign = [&](const std::string& xml) {
    return data_uri(
        as_text(*permissions_ca.sign_document(as_bytes(xml), pki::kNow, pki::test_random())));
  };
  const auto key = leaf.key.to_pem()->expose([](BytesView pem) { return data_uri(as_text(pem)); });
  namespace property = spi::property;
  return {
      {std::string(property::kIdentityCa), data_uri(identity_ca.certificate().pem()), false},
      {std::string(property::kIdentityCertificate), data_uri(leaf.certificate.pem()), false},
      {std::string(property::kPrivateKey), key, false},
      {std::string(property::kPermissionsCa), data_uri(permissions_ca.certificate().pem()), false},
      {std::string(property::kGovernance), sign(governance::to_xml(rules.document())), false},
      {std::string(property::kPermissions),
       sign(governance::to_xml(governance::Permissions{.grants = {grant}})), false}};
}

/// The CA's revocation list in a file, which need not exist at first. A participant with its
/// properties looks at it once a second.
class RevocationFile {
 public:
  spi::PropertyList watched_by(spi::PropertyList properties) const {
    namespace property = spi::property;
    properties.push_back(
        {std::string(property::kLaterCrl), "file:" + folder_.path() + "/crl.pem", false});
    properties.push_back({std::string(property::kFilesPollInterval), "1", false});
    return properties;
  }
  /// Puts the next list in place.
  void revoke(const spi::PropertyList& whose) {
    const auto* uri = spi::find_property(whose, spi::property::kIdentityCertificate);
    revoked_.push_back(
        *pki::Certificate::from_pem(as_bytes(std::string_view(*uri).substr(data_uri("").size()))));
    const pki::CrlTemplate content{.revoked = revoked_,
                                   .this_update = pki::kNow,
                                   .next_update = pki::kNow + 24h,
                                   .number = ++number_};
    folder_.replace("crl.pem", Authorities::shared().identity_ca.make_crl(content)->pem());
  }

 private:
  const test::TemporaryFolder folder_;
  std::vector<pki::Certificate> revoked_;
  std::uint64_t number_ = 0;
};

/// A participant at port 7000 + n, with plugins of its own if it is secured.
struct Node {
  struct Post final : Transport {
    std::vector<std::pair<std::uint32_t, Bytes>> sent;
    void send(BytesView octets, std::span<const Locator> to) override {
      for (const auto& locator : to) sent.emplace_back(locator.port, to_bytes(octets));
    }
  };

  static GuidPrefix candidate(std::uint8_t n) { return GuidPrefix::from(Bytes(12, n)); }
  /// Returns the configuration of a participant that announces itself to the first `others`.
  static ParticipantConfig config(std::uint8_t n, const GuidPrefix& prefix, int others = 3) {
    const auto at = [](std::uint32_t port) {
      return *Locator::parse("127.0.0.1", static_cast<std::uint16_t>(port));
    };
    LocatorList announce_to;
    for (int i = 1; i <= others; ++i) announce_to.push_back(at(7000u + static_cast<unsigned>(i)));
    return {.prefix = prefix,
            .metatraffic_unicast = {at(7000u + n)},
            .default_unicast = {at(7000u + n)},
            .announce_to = std::move(announce_to),
            .address_secret = sha256(prefix.octets)};
  }
  /// Makes an unsecured participant.
  explicit Node(std::uint8_t n) : port(7000u + n), random(n) {
    participant = std::make_unique<RtpsParticipant>(config(n, candidate(n)), post, events);
  }
  /// Wraps the cryptography of a participant.
  using Wrap =
      std::function<std::unique_ptr<spi::Cryptography>(std::unique_ptr<spi::Cryptography>)>;
  Node(std::uint8_t n, const spi::PropertyList& properties, int others = 3, const Wrap& wrap = {})
      : port(7000u + n), random(n) {
    const PluginServices services{clock, random, events};
    authentication = authentication::make_authentication(services);
    access_control =
        access_control::make_access_control(services, {.host_revises_keys = true,
                                                       .host_has_pre_shared_keys = true,
                                                       .host_changes_protection = true});
    cryptography = cryptography::make_cryptography(services);
    if (wrap) cryptography = wrap(std::move(cryptography));
    join(n, *this, properties, others);
  }
  /// Uses the plugins, and so the clock, of another node, which must live longer.
  Node(std::uint8_t n, const spi::PropertyList& properties, Node& host)
      : port(7000u + n), random(n) {
    join(n, host, properties, 3);
  }
  RtpsParticipant* operator->() { return participant.get(); }
  bool knows(const Node& other) const {
    return participant->is_authenticated(other.participant->prefix());
  }

  Post post;
  test::RecordedEvents events;
  std::uint32_t port;
  ManualClock clock{pki::kNow};
  SeededRandom random;
  std::unique_ptr<spi::Authentication> authentication;
  std::unique_ptr<spi::AccessControl> access_control;
  std::unique_ptr<spi::Cryptography> cryptography;
  Listener listener;
  std::unique_ptr<RtpsParticipant> participant;

 private:
  void join(std::uint8_t n, Node& host, const spi::PropertyList& properties, int others) {
    auto own = OwnSecurity::create(
        {{*host.authentication, *host.access_control, *host.cryptography}, properties}, 0,
        candidate(n));
    EXPECT_TRUE(own) << own.error().to_sentence();
    if (!own) return;
    participant =
        std::make_unique<RtpsParticipant>(config(n, (*own)->guid().prefix, others), post, events);
    const auto secured = participant->enable_security(std::move(*own));
    EXPECT_TRUE(secured) << secured.error().to_sentence();
  }
};

inline std::vector<Bytes> one(Bytes datagram) { return std::vector<Bytes>(1, std::move(datagram)); }

/// Carries datagrams. A filter may lose, change or add some.
struct World {
  using Filter = std::function<std::vector<Bytes>(const Node& from, Bytes datagram)>;
  std::vector<Node*> nodes;
  MonotonicTime now = seconds(1);
  Filter filter = {};

  using Traffic = std::vector<std::pair<std::uint32_t, Bytes>>;
  /// Sees what arrives in one step, by port, and may add to it or change its order.
  std::function<void(Traffic&)> attack = {};

  void run(int steps = 60) {
    for (int i = 0; i < steps; ++i) {
      Traffic traffic;
      for (auto* from : nodes)
        for (auto& [port, octets] : std::exchange(from->post.sent, {}))
          for (auto& datagram : filter ? filter(*from, std::move(octets)) : one(std::move(octets)))
            traffic.emplace_back(port, std::move(datagram));
      if (attack) attack(traffic);
      for (const auto& [port, datagram] : traffic)
        for (auto* to : nodes)
          if (to->port == port) (*to)->receive(datagram, now, *Locator::parse("127.0.0.1", 0));
      now += milliseconds(10);
      for (auto* node : nodes) (*node)->tick(now);
    }
  }
  /// From now on, loses all messages of that node.
  void silence(const Node& sender) {
    filter = [&sender](const Node& from, Bytes datagram) {
      return &from == &sender ? std::vector<Bytes>{} : one(std::move(datagram));
    };
  }
  /// True once `done` is true. Runs at most that many steps of 10 ms.
  bool run_until(const std::function<bool()>& done, int steps = 3000) {
    for (int i = 0; i < steps && !done(); ++i) run(1);
    return done();
  }
};

inline EndpointDescription square(Qos qos) { return {"Square", "ShapeType", std::move(qos), true}; }
inline Payload payload(std::size_t size = 8) {
  Bytes octets(size, 0x5a);
  octets[0] = 0;
  octets[1] = 1;
  octets[2] = octets[3] = 0;
  return Payload::copy_of(octets);
}
using test::code_of;

/// A publisher and a subscriber of one topic under one governance.
struct Pair {
  explicit Pair(const Rules& rules) : Pair(rules, rules) {}
  Pair(const Rules& of_a, const Rules& of_b)
      : a(1, properties_of("CN=alice,O=Example", of_a)),
        b(2, properties_of("CN=bob,O=Example", of_b)) {
    world.nodes = {&a, &b};
  }
  /// Makes a pair with further properties for each participant.
  Pair(const Rules& of_a, const Rules& of_b, const spi::PropertyList& more_of_a,
       const spi::PropertyList& more_of_b)
      : a(1, both(properties_of("CN=alice,O=Example", of_a), more_of_a)),
        b(2, both(properties_of("CN=bob,O=Example", of_b), more_of_b)) {
    world.nodes = {&a, &b};
  }
  static spi::PropertyList both(spi::PropertyList one, const spi::PropertyList& other) {
    one.insert(one.end(), other.begin(), other.end());
    return one;
  }
  void create_endpoints() {
    writer = a->create_writer(square(default_writer_qos()), a.listener, world.now).value();
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    reader = b->create_reader(square(qos), b.listener, world.now).value();
  }
  bool match() {
    create_endpoints();
    return world.run_until([&] { return a.listener.matched == 1 && b.listener.matched == 1; });
  }
  void write(std::size_t size = 8) {
    Change change;
    change.payload = payload(size);
    a->local_endpoints().writer(writer)->write(std::move(change), world.now);
  }
  Node a, b;
  World world;
  Guid writer, reader;
};

}  // namespace ddssec::rtps::testing
