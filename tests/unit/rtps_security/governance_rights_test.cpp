// A governance document changes rights while it waits, or the topics in use change. No participant
// keeps what the new document denies, and nothing is protected less.
#include "plugins/spi/governance_change_time.hpp"
#include "tests/unit/rtps_security/key_thief.hpp"
#include "tests/unit/rtps_security/recorder.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kNone = ProtectionKind::none, kSign = ProtectionKind::sign,
               kEncrypt = ProtectionKind::encrypt;

struct Topic {
  std::string name;
  ProtectionKind kind = kSign;
  bool readers_need_permission = true;
};

struct Document {
  std::vector<Topic> topics;
  std::uint32_t revision = 1;
  bool revises_keys = false;
  const pki::Authority* ca = &Authorities::shared().permissions_ca;

  std::string text() const {
    const Rules rules{.rtps = kSign, .discovery = kSign, .revises_keys = revises_keys};
    auto document = rules.document();
    auto& rule = document.domain_rules[0];
    const auto any = std::exchange(rule.topic_rules, {}).front();
    for (const auto& [name, kind, readers_need_permission] : topics) {
      auto topic = any;
      topic.topic_expression = name;
      topic.enable_read_access_control = readers_need_permission;
      topic.metadata_protection_kind = topic.data_protection_kind = kind;
      rule.topic_rules.push_back(std::move(topic));
    }
    document.revision = revision;
    return std::string(as_text(
        *ca->sign_document(as_bytes(governance::to_xml(document)), pki::kNow, pki::test_random())));
  }
};

std::string permissions_of(const std::string& name, std::vector<std::string> topics) {
  const auto all = properties_of("CN=" + name + ",O=Example", {}, std::move(topics));
  return spi::find_property(all, spi::property::kPermissions)->substr(data_uri("").size());
}

const pki::Authority* first_ca() { return &Authorities::shared().permissions_ca; }
const pki::Authority* second_ca() {
  static const auto ca = pki::make_ca("CN=Second Permissions CA,O=Example");
  return &ca;
}
std::string bundle(std::initializer_list<const pki::Authority*> cas) {
  std::string out;
  for (const auto* ca : cas) out += ca->certificate().pem();
  return out;
}

struct Member {
  Member(std::uint8_t n, std::string called, const Document& document,
         std::vector<std::string> topics = {"*"}, const Node::Wrap& wrap = {})
      : name(std::move(called)), node(n, properties(document, std::move(topics)), 4, wrap) {}
  spi::PropertyList properties(const Document& document, std::vector<std::string> topics) const {
    auto out = properties_of("CN=" + name + ",O=Example", {});
    for (auto& one : out) {
      if (one.name == spi::property::kGovernance)
        one.value = "file:" + folder.write("governance.p7s", document.text());
      if (one.name == spi::property::kPermissionsCa)
        one.value = "file:" + folder.write("ca.pem", bundle({first_ca(), second_ca()}));
      if (one.name == spi::property::kPermissions)
        one.value =
            "file:" + folder.write("permissions.p7s", permissions_of(name, std::move(topics)));
    }
    out.push_back({std::string(spi::property::kFilesPollInterval), "1", false});
    out.push_back({std::string(spi::property::kGovernanceChangeTime), "20", false});
    return out;
  }
  void put(const Document& document) { folder.replace("governance.p7s", document.text()); }
  void permit(std::vector<std::string> topics) {
    folder.replace("permissions.p7s", permissions_of(name, std::move(topics)));
  }
  const test::TemporaryFolder folder;
  const std::string name;
  Node node;
};

// Alice writes, and bob and carol read.
struct Three {
  explicit Three(const Document& former, std::vector<std::string> topics_of_carol = {"*"})
      : a(1, "alice", former),
        b(2, "bob", former),
        c(3, "carol", former, std::move(topics_of_carol), KeyThief::into(stolen)) {
    world.nodes = {&a.node, &b.node, &c.node};
    world.filter = [this](const Node& from, Bytes datagram) {
      if (watches && &from == &a.node) sent.push_back(datagram);
      return one(std::move(datagram));
    };
    writer = add_writer("Square", a.node.listener).value();
    for (auto* member : {&b, &c}) EXPECT_TRUE(add_reader(*member, "Square", member->node.listener));
    EXPECT_TRUE(world.run_until([&] {
      return a.node.listener.matched == 2 && b.node.listener.matched == 1 &&
             c.node.listener.matched == 1;
    })) << text();
  }
  Result<Guid> add_writer(const std::string& topic, Listener& listener) {
    auto request = square(default_writer_qos());
    request.qos.history.kind = HistoryKind::keep_all;
    request.topic_name = topic;
    return a.node->create_writer(std::move(request), listener, world.now);
  }
  Result<Guid> add_reader(Member& member, const std::string& topic, Listener& listener) {
    auto request = square(default_reader_qos());
    request.qos.reliability.kind = ReliabilityKind::reliable;
    request.qos.history.kind = HistoryKind::keep_all;
    request.topic_name = topic;
    return member.node->create_reader(std::move(request), listener, world.now);
  }
  void put(std::initializer_list<Member*> members, const Document& document) {
    for (auto* member : members) member->put(document);
  }
  void run(int seconds) {
    for (int i = 0; i < seconds; ++i) {
      for (auto* node : world.nodes) node->clock.advance(1s);
      for (int j = 0; j < 10; ++j) {
        Change change;
        change.payload = payload(64);
        a.node->local_endpoints().writer(writer)->write(std::move(change), world.now);
        ++written;
        world.run(10);
      }
    }
  }
  bool bob_has_all() {
    return world.run_until([&] { return b.node.listener.changes.size() == written; }, 1000);
  }
  int renewed(Member& member) { return member.node.events.count(Code::governance_renewed); }
  std::string text() const {
    return "A " + a.node.events.text() + "B " + b.node.events.text() + "C " + c.node.events.text();
  }

  KeyThief::Stolen stolen;
  Member a, b, c;
  World world;
  Guid writer;
  std::size_t written = 0;
  bool watches = false;
  std::vector<Bytes> sent;
};

// Carol matched by the old rule, but she must not get the keys of the new protection.
TEST(GovernanceRights, ReaderThatLosesItsRight_GetsNoKeysOfTheNewProtection) {
  for (const bool revises_keys : {false, true}) {
    Three three({{{"Square", kSign, false}, {"*"}}, 1, revises_keys}, {"Other"});
    three.run(3);
    three.put({&three.a, &three.b, &three.c},
              {{{"Square", kEncrypt, true}, {"*"}}, 2, revises_keys});
    three.run(15);
    EXPECT_EQ(three.renewed(three.a), 1) << three.text();
    EXPECT_EQ(three.a.node.listener.matched, 1) << three.text();
    EXPECT_EQ(three.c.node.listener.matched, 0) << "it judges itself, too" << three.text();
    EXPECT_TRUE(three.c.node.events.has(Code::subscribe_not_allowed)) << three.text();
    EXPECT_TRUE(three.bob_has_all()) << three.text();
    EXPECT_EQ(three.b.node.listener.unmatched, 0) << three.text();
    EXPECT_EQ(three.a.node.events.has(Code::rtps_keys_revised), revises_keys) << three.text();
    three.run(20);
    three.watches = true;
    three.run(2);
    Recorder thief(three.stolen);
    for (const auto& datagram : three.sent) thief.read(datagram);
    EXPECT_EQ(thief.groups.opened + thief.payloads.opened, 0) << revises_keys;
  }
}

// A CA leaves at once if its key was stolen.
TEST(GovernanceRights, CaLeavesAndAnotherDocumentComesAtOnce_TheOtherOneIsTaken) {
  Three three({{{"Square"}, {"*"}}});
  three.put({&three.a}, {{{"Square", kEncrypt}, {"*"}}, 5, false, second_ca()});
  three.run(4);
  EXPECT_TRUE(three.a.node.events.has(Code::governance_changing)) << three.text();
  for (auto* member : {&three.a, &three.b, &three.c}) {
    member->folder.replace("ca.pem", bundle({first_ca()}));
    member->put({{{"Square", kEncrypt}, {"Further"}, {"*"}}, 9});
  }
  three.run(25);
  for (auto* member : {&three.a, &three.b, &three.c}) {
    EXPECT_EQ(three.renewed(*member), 1) << three.text();
    EXPECT_EQ(member->node.listener.unmatched, 0) << three.text();
    EXPECT_FALSE(member->node.events.has(Code::governance_peer_behind)) << three.text();
  }
  EXPECT_TRUE(three.bob_has_all()) << three.text();
}

TEST(GovernanceRights, PeerWithALaterDocument_IsCalledAhead) {
  Three three({{{"Square"}, {"*"}}});
  three.put({&three.a}, {{{"Square", kEncrypt}, {"*"}}, 2});
  three.put({&three.b, &three.c}, {{{"Square", kEncrypt}, {"Further"}, {"*"}}, 3});
  three.run(25);
  EXPECT_EQ(three.a.node.events.count(Code::governance_peer_ahead), 2) << three.text();
  EXPECT_FALSE(three.a.node.events.has(Code::governance_peer_behind)) << three.text();
  EXPECT_TRUE(three.b.node.events.has(Code::governance_peer_behind)) << three.text();
}

// An insider that causes one revision after the other must not delay the change for longer.
TEST(GovernanceRights, RevisionsWithoutEnd_DelayTheChangeForNoLongerThanItsTime) {
  Three three({{{"Square"}, {"*"}}, 1, true});
  three.put({&three.a, &three.b, &three.c}, {{{"Square", kEncrypt}, {"*"}}, 2, true});
  for (int i = 0; i < 30; ++i) {
    for (auto* node : three.world.nodes) EXPECT_TRUE((*node)->revise_keys());
    three.run(1);
  }
  for (auto* member : {&three.a, &three.b, &three.c})
    EXPECT_EQ(three.renewed(*member), 1) << three.text();
  EXPECT_TRUE(three.bob_has_all()) << three.text();
}

// The change must not end for all at once, or it would part participants that get the document
// later.
TEST(GovernanceRights, PeerThatLosesARightMeanwhile_EndsNoPhase) {
  Three three({{{"Square"}, {"*"}}, 1, true});
  const Document next{{{"Square", kEncrypt}, {"*"}}, 2, true};
  three.put({&three.a}, next);
  three.run(3);
  EXPECT_TRUE(three.a.node.events.has(Code::governance_changing)) << three.text();
  three.c.permit({"Other"});
  three.run(5);
  EXPECT_EQ(three.a.node.listener.matched, 1) << three.text();
  EXPECT_EQ(three.renewed(three.a), 0) << three.text();
  three.put({&three.b, &three.c}, next);
  three.run(12);
  EXPECT_EQ(three.renewed(three.a), 1) << three.text();
  EXPECT_EQ(three.b.node.listener.unmatched, 0) << three.text();
  EXPECT_TRUE(three.bob_has_all()) << three.text();
  EXPECT_TRUE(three.a.node.events.has(Code::rtps_keys_revised)) << three.text();
}

// If only the topics in use when the document was read counted, the document would leave this topic
// unprotected.
TEST(GovernanceRights, TopicThatComesIntoUseMeanwhile_IsNotProtectedLess) {
  Three three({{{"Square"}, {"*", kEncrypt}}});
  three.put({&three.a, &three.b}, {{{"Square", kEncrypt}, {"Secret", kNone}, {"*", kEncrypt}}, 2});
  three.run(3);
  ASSERT_TRUE(three.a.node.events.has(Code::governance_changing)) << three.text();
  Listener writes;
  EXPECT_EQ(code_of(three.add_writer("Secret", writes)), Code::governance_change_under_way);
  const auto other = three.add_writer("Any", writes);
  EXPECT_TRUE(other) << other.error().to_sentence();
  three.run(60);
  EXPECT_EQ(three.renewed(three.a), 1) << three.text();
  EXPECT_TRUE(three.add_writer("Secret", writes)) << "by the rule that everybody has now";
}

}  // namespace
}  // namespace ddssec::rtps
