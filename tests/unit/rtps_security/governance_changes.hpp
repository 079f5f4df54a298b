// Participants whose governance document is replaced.
#pragma once

#include <random>

#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/document_files.hpp"
#include "tests/unit/rtps_security/segments.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps::governance_changes {

using namespace testing;

inline constexpr auto kNone = ProtectionKind::none, kSign = ProtectionKind::sign,
                      kEncrypt = ProtectionKind::encrypt;

inline Rules rules_of(ProtectionKind metadata, ProtectionKind data, ProtectionKind rtps = kSign) {
  return {.rtps = rtps, .discovery = kSign, .metadata = metadata, .data = data};
}

inline std::string governance(const Rules& rules, std::uint32_t revision) {
  auto document = rules.document();
  document.revision = revision;
  return std::string(as_text(*Authorities::shared().permissions_ca.sign_document(
      as_bytes(governance::to_xml(document)), pki::kNow, pki::test_random())));
}

/// A participant whose governance document is in a file.
struct Member {
  Member(std::uint8_t n, const std::string& name, const Rules& rules, const std::string& seconds)
      : path(folder.write("governance.p7s", governance(rules, 1))),
        node(n, properties(name, rules, seconds), 4) {}
  spi::PropertyList properties(const std::string& name, const Rules& rules,
                               const std::string& seconds) const {
    auto out = properties_of("CN=" + name + ",O=Example", rules);
    for (auto& one : out)
      if (one.name == spi::property::kGovernance) one.value = "file:" + path;
    out.push_back({std::string(spi::property::kFilesPollInterval), "1", false});
    out.push_back({std::string(spi::property::kGovernanceChangeTime), seconds, false});
    out.push_back({std::string(spi::property::kSharedMemory), "on", false});
    return out;
  }
  const test::TemporaryFolder folder;
  const std::string path;
  Node node;
};

/// Alice writes to bob and carol. Bob answers on another topic.
struct Fleet {
  explicit Fleet(const Rules& former, const std::string& seconds = "30", bool has_carol = true)
      : a(1, "alice", former, seconds),
        b(2, "bob", former, seconds),
        c(3, "carol", former, seconds) {
    world.nodes = {&a.node, &b.node};
    if (has_carol) world.nodes.push_back(&c.node);
    world.filter = [this](const Node&, Bytes datagram) {
      if (watches) sent.push_back(datagram);
      return is_lossy && random() % 100 < loss ? std::vector<Bytes>{} : one(std::move(datagram));
    };
    auto qos = default_writer_qos();
    qos.history.kind = HistoryKind::keep_all;
    auto reading = default_reader_qos();
    reading.reliability.kind = ReliabilityKind::reliable;
    reading.history.kind = HistoryKind::keep_all;
    writer = a.node->create_writer(square(qos), a.node.listener, world.now).value();
    for (auto* node : world.nodes)
      if (node != &a.node)
        readers[node] = (*node)->create_reader(square(reading), node->listener, world.now).value();
    const auto count = static_cast<int>(world.nodes.size()) - 1;
    EXPECT_TRUE(world.run_until([&] {
      return a.node.listener.matched == count && std::ranges::all_of(world.nodes, [&](Node* node) {
               return node == &a.node || node->listener.matched == 1;
             });
    })) << text();
  }
  void put(std::initializer_list<Member*> members, const Rules& rules, std::uint32_t revision) {
    for (auto* member : members)
      member->folder.replace("governance.p7s", governance(rules, revision));
  }
  void write() {
    Change change;
    change.payload = Payload::copy_of(marked());
    a.node->local_endpoints().writer(writer)->write(std::move(change), world.now);
    ++written;
  }
  /// Returns a sample whose text can be found on the network if it is not encrypted.
  Bytes marked() const {
    Bytes octets{0, 1, 0, 0};
    for (const char c : kMark) octets.push_back(static_cast<std::uint8_t>(c));
    octets.resize(octets.size() + more, 0x5a);
    return octets;
  }
  /// Writes all the time, while the plugins look at their files once a second.
  void run(int seconds) {
    for (int i = 0; i < seconds; ++i) {
      for (auto* node : world.nodes) node->clock.advance(1s);
      for (int j = 0; j < 10; ++j) {
        write();
        world.run(10);
      }
    }
  }
  bool has_all(Node& node) {
    return world.run_until([&] { return node.listener.changes.size() == written; }, 3000);
  }
  bool is_whole(const Node& node) const {
    return std::ranges::all_of(node.listener.changes, [this](const Change& change) {
      return std::ranges::equal(change.payload.view(), marked());
    });
  }
  bool is_readable_on_the_network() {
    sent.clear();
    watches = true;
    run(2);
    watches = false;
    return std::ranges::any_of(sent, [](const Bytes& datagram) {
      return as_text(datagram).find(kMark) != std::string_view::npos;
    });
  }
  static int unmatched(const Node& node) { return node.listener.unmatched; }
  std::string text() const {
    return "A " + a.node.events.text() + "B " + b.node.events.text() + "C " + c.node.events.text();
  }

  static constexpr std::string_view kMark = "what everyone could read before.";
  Member a, b, c;
  World world;
  Guid writer;
  std::map<const Node*, Guid> readers;
  std::size_t written = 0, more = 0;  ///< more: octets of each sample after the text
  bool watches = false, is_lossy = false;
  unsigned loss = 20;  ///< in percent
  std::vector<Bytes> sent;
  std::minstd_rand random{7};
};

/// Alice and bob are in the second phase. Carol has the document, but nothing is heard of her any
/// more, so the others still accept her former protection.
struct SecondPhase : Fleet {
  SecondPhase(const Rules& former, const Rules& next) : Fleet(former, "4") {
    of_carol = c.node->create_writer(square(default_writer_qos()), silent, world.now).value();
    run(1);
    put({&a, &b, &c}, next, 2);
    world.filter = [this](const Node& from, Bytes datagram) {
      if (&from == &c.node && c.node.events.has(Code::governance_changing) && world.now > mute_from)
        return std::vector<Bytes>{};
      return one(std::move(datagram));
    };
    for (int i = 0; i < 10 && !is_reached(); ++i) {
      run(1);
      if (c.node.events.has(Code::governance_changing) && mute_from == kNever)
        mute_from = world.now;
    }
    EXPECT_TRUE(is_reached()) << text();
    world.run(20);
  }
  bool is_reached() const {
    return a.node.events.has(Code::governance_renewed) &&
           b.node.events.has(Code::governance_renewed);
  }
  MonotonicTime mute_from = kNever;
  Listener silent;
  Guid of_carol;
};

/// Returns a sample without any protection. Its number is the next one of the writer.
inline Bytes clear_sample(const Fleet& fleet, const Guid& writer, std::size_t written) {
  const auto payload = fleet.marked();
  return testing::forged(writer.prefix, Data{kEntityIdUnknown,
                                             writer.entity,
                                             {static_cast<std::int64_t>(written) + 1},
                                             {},
                                             PayloadKind::data,
                                             payload});
}

/// Returns true if bob takes the sample that clear_sample() returns.
inline bool takes_clear_sample(Fleet& fleet, const Guid& writer, std::size_t written) {
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  const auto before = fleet.b.node.listener.changes.size();
  fleet.b.node->receive(clear_sample(fleet, writer, written), fleet.world.now,
                        *Locator::parse("127.0.0.1", 0));
  return fleet.b.node.listener.changes.size() > before;
}

/// Expects that a and b change their protection in time, although carol says that she has the
/// document, and acknowledges nothing from then on. All have the document already.
inline void expect_change_beside_a_mute_carol(Fleet& fleet) {
  fleet.world.filter = [&](const Node& from, Bytes datagram) {
    if (fleet.watches) fleet.sent.push_back(datagram);
    const bool is_mute =
        &from == &fleet.c.node && fleet.c.node.events.has(Code::governance_changing);
    return is_mute ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  fleet.run(12);
  EXPECT_FALSE(fleet.is_readable_on_the_network()) << fleet.text();
  fleet.run(16);
  EXPECT_EQ(fleet.a.node.events.count(Code::governance_renewed), 1) << fleet.text();
  EXPECT_TRUE(fleet.has_all(fleet.b.node)) << fleet.text();
  EXPECT_EQ(Fleet::unmatched(fleet.b.node), 0);
}

}  // namespace ddssec::rtps::governance_changes
