// Three participants of a domain that revises keys. One of them keeps every key that it gets.
#pragma once

#include "tests/unit/rtps_security/recorder.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps::testing {

inline Rules revising(Rules rules) {
  rules.revises_keys = true;
  return rules;
}

/// The document that is valid for half a day only.
enum class Short { nothing, permissions, certificate };

inline spi::PropertyList member(const std::string& name, const Rules& rules,
                                Short what = Short::nothing) {
  const auto subject = "CN=" + name + ",O=Example";
  if (what == Short::permissions) return properties_of(subject, rules, {"*"}, 12h);
  auto properties = properties_of(subject, rules);
  if (what == Short::nothing) return properties;
  const auto leaf = pki::make_leaf(Authorities::shared().identity_ca, subject, {},
                                   {pki::kNow - 24h, pki::kNow + 12h});
  const auto key = leaf.key.to_pem()->expose([](BytesView pem) { return data_uri(as_text(pem)); });
  for (auto& property : properties) {
    if (property.name == spi::property::kIdentityCertificate)
      property.value = data_uri(leaf.certificate.pem());
    if (property.name == spi::property::kPrivateKey) property.value = key;
  }
  return properties;
}

/// Alice writes to bob and carol. Carol's plugin keeps every key that it gets. `more` are further
/// properties of alice and bob.
struct Trio {
  explicit Trio(const Rules& rules, Short of_carol = Short::nothing,
                const spi::PropertyList& more = {})
      : rules(rules),
        carol(member("carol", rules, of_carol)),
        a(1, Pair::both(list.watched_by(member("alice", rules)), more), 4),
        b(2, Pair::both(list.watched_by(member("bob", rules)), more), 4),
        c(3, carol, 4, KeyThief::into(stolen)) {
    world.nodes = {&a, &b, &c};
  }

  void read(Node& node) {
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    qos.history.kind = HistoryKind::keep_all;
    EXPECT_TRUE(node->create_reader(square(qos), node.listener, world.now));
  }
  bool match() {
    auto qos = default_writer_qos();
    qos.history.kind = HistoryKind::keep_all;
    qos.liveliness.lease_duration = Duration{{1, 0}};
    writer = a->create_writer(square(qos), a.listener, world.now).value();
    read(b);
    read(c);
    const bool done = world.run_until([&] {
      return a.listener.matched == 2 && b.listener.matched == 1 && c.listener.matched == 1;
    });
    world.run(100);
    return done;
  }
  void write(std::size_t size = 64) {
    Change change;
    change.payload = payload(size);
    a->local_endpoints().writer(writer)->write(std::move(change), world.now);
    ++written;
  }
  bool bob_has_all() {
    return world.run_until([&] { return b.listener.changes.size() == written; }, 3000);
  }
  bool revised(int times, int steps = 1500) {
    return world.run_until(
        [&] {
          return a.events.count(Code::rtps_keys_revised) >= times &&
                 b.events.count(Code::rtps_keys_revised) >= times;
        },
        steps);
  }
  void revoke_carol() {
    list.revoke(carol);
    for (auto* node : {&a, &b}) node->clock.advance(1s);
  }
  void ignore(Node& whom) {
    for (auto* node : {&a, &b})
      if (node != &whom) (*node)->ignore_participant(whom->prefix());
  }
  std::string text() { return a.events.text() + b.events.text() + c.events.text(); }

  const Rules rules;
  const spi::PropertyList carol;
  RevocationFile list;
  KeyThief::Stolen stolen;
  Node a, b, c;
  World world;
  Guid writer;
  std::size_t written = 0;
};

/// Passes everything that alice and bob send to the recorder.
inline void record(Trio& trio, Recorder& recorder) {
  trio.world.filter = [&](const Node& from, Bytes datagram) {
    if (&from != &trio.c) recorder.read(datagram);
    return one(std::move(datagram));
  };
}

/// Causes some messages of all kinds: samples, announcements, liveliness, acknowledgments.
inline void traffic(Trio& trio) {
  for (int i = 0; i < 3; ++i) {
    trio.write();
    trio.world.run(20);
  }
  const auto extra = trio.a->create_writer({"Circle", "ShapeType", default_writer_qos(), true},
                                           trio.a.listener, trio.world.now);
  ASSERT_TRUE(extra);
  trio.world.run(300);
  trio.a->remove(*extra, trio.world.now);
  trio.world.run(50);
}

}  // namespace ddssec::rtps::testing
