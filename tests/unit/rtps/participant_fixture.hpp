// Participants without sockets. The test carries their datagrams and moves their time.
#pragma once

#include <set>

#include "rtps/participant/rtps_participant.hpp"
#include "tests/support/recorded_events.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps::testing::socketless {

using std::chrono::milliseconds;
using std::chrono::seconds;

struct Listener : EndpointListener {
  int matched = 0;
  std::vector<QosMismatch> mismatches;
  std::vector<Change> changes;
  int inconsistent = 0;
  std::vector<Guid> alive;
  std::vector<Qos> announced;
  std::int64_t lost = 0;
  void on_matched(const EndpointData& remote) override {
    matched += known.insert(remote.guid).second ? 1 : 0;
    announced.push_back(remote.qos);
  }
  void on_unmatched(const Guid& remote) override {
    matched -= known.erase(remote) ? 1 : 0;
    signals.erase(remote);
  }
  void on_inconsistent_topic(const EndpointData&) override { ++inconsistent; }
  void on_sample_lost(std::int64_t count) override { lost += count; }
  /// Asks to be notified of each assertion.
  void on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) override {
    signals[writer] = signal;
    if (signal) signal->notify(*this, writer);
  }
  void on_alive(const Guid& writer) override {
    alive.push_back(writer);
    if (const auto& signal = signals[writer]) signal->notify(*this, writer);
  }
  std::map<Guid, std::shared_ptr<LivelinessSignal>> signals;
  std::set<Guid> known;
  void on_incompatible_qos(const Guid&, const QosMismatch& m) override { mismatches.push_back(m); }
  bool on_change(Change& change) override {
    changes.push_back(std::move(change));
    return true;
  }
  void on_acknowledged() override {}
};

/// A participant at port 7000 + n of a network that the test carries.
struct Node {
  struct Post final : Transport {
    std::vector<std::pair<std::uint32_t, Bytes>> sent;
    void send(BytesView octets, std::span<const Locator> to) override {
      for (const auto& locator : to) sent.emplace_back(locator.port, to_bytes(octets));
    }
  };
  Post post;
  test::RecordedEvents events;
  std::uint32_t port;
  Listener listener;  // it outlives its endpoints
  RtpsParticipant participant;

  static ParticipantConfig config(std::uint8_t n, DomainId domain, std::string tag,
                                  std::int32_t lease) {
    const auto at = [](std::uint32_t port) {
      return *Locator::parse("127.0.0.1", static_cast<std::uint16_t>(port));
    };
    return {.prefix = GuidPrefix::from(Bytes(12, n)),
            .domain_id = domain,
            .domain_tag = std::move(tag),
            .lease_duration = {{lease, 0}},
            .metatraffic_unicast = {at(7000u + n)},
            .default_unicast = {at(7000u + n)},
            .announce_to = {at(7001), at(7002), at(7003)}};
  }
  explicit Node(std::uint8_t n, DomainId domain = 0, std::string tag = {}, std::int32_t lease = 10)
      : port(7000u + n), participant(config(n, domain, std::move(tag), lease), post, events) {}
};

struct World {
  std::vector<Node*> nodes;
  MonotonicTime now = seconds(1);
  void run(int steps = 30) {
    for (int i = 0; i < steps; ++i) {
      for (auto* from : nodes)
        for (auto& [port, octets] : std::exchange(from->post.sent, {}))
          for (auto* to : nodes)
            if (to->port == port) to->participant.receive(octets, now);
      now += milliseconds(10);
      for (auto* node : nodes) node->participant.tick(now);
    }
  }
};

}  // namespace ddssec::rtps::testing::socketless
