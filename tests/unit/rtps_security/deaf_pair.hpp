// A peer of another product that is not heard for longer than its lease, but hears us. It keeps its
// session, and answers no other handshake.
#pragma once

#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps::testing {

inline bool contains(BytesView datagram, const EntityId& id) {
  return !std::ranges::search(datagram, id.octets).empty();
}

inline RemoteParticipants& remotes_of(Node& node) {
  return const_cast<RemoteParticipants&>(node.participant->remote_participants());
}

inline SecurityCore& core_of(Node& node) {
  return const_cast<ParticipantCore&>(remotes_of(node).core()).security->core();
}

// From now on `ours` takes the other node for one of a stock Cyclone DDS.
inline void treat_as_stock(Node& ours, const Node& other, VendorId vendor = kVendorCyclone) {
  auto& peer = *core_of(ours).find(other.participant->prefix());
  peer.data.vendor = vendor;
  peer.state.association()->reset.reset();
  remotes_of(ours).find(other.participant->prefix())->data.vendor = vendor;
}

// The other node is as patient as a product that takes clear announcements for signs of life.
inline void be_patient(Node& stock, const Node& ours) {
  auto& known = *remotes_of(stock).find(ours.participant->prefix());
  known.data.lease_duration = kDurationInfinite;
  remotes_of(stock).renew_lease(known, known.data);
}

// Participant a is ours, and b is the stock one. Both write and read.
struct DeafPair {
  explicit DeafPair(const Rules& of_both) : rules(of_both) {
    world.nodes = {&a, &b};
    world.filter = [this](const Node& from, Bytes datagram) {
      const bool is_handshake = contains(datagram, kStatelessMessageWriter);
      if (is_handshake && keeps_session) return std::vector<Bytes>{};
      if (&from == &b) recorded.push_back(datagram);
      const bool is_lost =
          &from == &b &&
          (is_unheard || (loses_keys && !is_handshake && !contains(datagram, kSpdpWriter)));
      return is_lost ? std::vector<Bytes>{} : one(std::move(datagram));
    };
  }
  Guid create(Node& node, bool writes, const char* topic) {
    auto qos = writes ? default_writer_qos() : default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    auto description = square(qos);
    description.topic_name = topic;
    return writes ? node->create_writer(description, node.listener, world.now).value()
                  : node->create_reader(description, node.listener, world.now).value();
  }
  bool are_matched(int count = 2) const {
    return a.listener.matched == count && b.listener.matched == count;
  }
  bool meet() {
    writers = {create(a, true, "Square"), create(b, true, "Circle")};
    create(a, false, "Circle");
    create(b, false, "Square");
    if (!world.run_until([&] { return are_matched(); })) return false;
    become_stock();
    return true;
  }
  void become_stock() {
    treat_as_stock(a, b);
    be_patient(b, a);
    keeps_session = true;
  }
  void write(Node& node) {
    Change change;
    change.payload = payload();
    node->local_endpoints()
        .writer(writers[&node == &a ? 0 : 1])
        ->write(std::move(change), world.now);
  }
  // Both ways; returns false if a sample does not arrive.
  bool samples_flow() {
    const auto before = std::pair(a.listener.changes.size(), b.listener.changes.size());
    write(a);
    write(b);
    return world.run_until(
        [&] {
          return a.listener.changes.size() > before.first &&
                 b.listener.changes.size() > before.second;
        },
        500);
  }
  bool lose_it() {
    is_unheard = true;
    return world.run_until([&] { return a->remote_participants().size() == 0; }, 4000);
  }
  bool is_dormant() { return core_of(a).dormant.contains(b->prefix()); }
  MonotonicTime lease() {
    return remotes_of(a).find(b->prefix())->data.lease_duration.to_nanoseconds();
  }

  const Rules rules;
  Node a{1, properties_of("CN=alice,O=Example", rules)};
  Node b{2, properties_of("CN=bob,O=Example", rules)};
  World world;
  bool keeps_session = false, is_unheard = false, loses_keys = false;
  std::vector<Guid> writers;
  std::vector<Bytes> recorded;
};

inline std::vector<Rules> rules_for_deaf_pairs() {
  using enum ProtectionKind;
  return {everything(sign),
          everything(encrypt_with_origin_authentication),
          {.rtps = encrypt},
          {.discovery = encrypt, .liveliness = encrypt, .metadata = sign},
          {.metadata = encrypt, .data = encrypt},
          {.data = encrypt},
          {}};
}

}  // namespace ddssec::rtps::testing
