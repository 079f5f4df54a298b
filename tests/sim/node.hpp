// One member of the cast: a real participant with real plugins, its endpoints, and its costs.
#pragma once

#include <set>

#include "tests/sim/insider.hpp"
#include "tests/sim/invariants.hpp"
#include "tests/sim/network.hpp"
#include "tests/support/seeded_random.hpp"

namespace ddssec::rtps::sim {

/// The parts of its world that a node needs.
struct Surroundings {
  const Protection& protection;
  const MonotonicTime& now;
  Ledger& ledger;
  Invariants& invariants;
  Malice& malice;
  Wire& wire;
  bool has_interfaces = false;  ///< participants know the address of their machine
};

/// An endpoint and its owner.
class Endpoint final : public EndpointListener {
 public:
  Endpoint(const Surroundings& around, const End& end) : around_(around), end_(end) {}
  const End& end() const { return end_; }
  void is_known_as(const Guid& guid);
  bool has_honest_peers_only() const;
  /// Returns the time since when they match; kNever if they do not.
  MonotonicTime matched_since(const Guid& remote) const;
  bool has(const Guid& writer, SequenceNumber number) const {
    return got_.contains({writer, number});
  }

 private:
  void on_matched(const EndpointData& remote) override;
  void on_unmatched(const Guid& remote) override;
  void on_incompatible_qos(const Guid&, const QosMismatch&) override {}
  void on_inconsistent_topic(const EndpointData&) override {}
  bool on_change(Change& change) override;
  void on_sample_lost(std::int64_t) override {}
  void on_signal(const Guid& writer, std::shared_ptr<LivelinessSignal> signal) override;
  void on_alive(const Guid& writer) override;
  void on_acknowledged() override {}

  const Surroundings& around_;
  End end_;
  std::map<Guid, MonotonicTime> matched_;
  std::map<Guid, std::shared_ptr<LivelinessSignal>> signals_;
  std::set<std::pair<Guid, SequenceNumber>> got_;
};

class Node final : private Transport, private EventSink {
 public:
  Node(const Surroundings& around, const Subject& subject, std::size_t number, Dice dice);
  ~Node() override { stop(false); }

  const Subject& subject() const { return subject_; }
  bool is_honest() const { return subject_.role == Role::honest; }
  bool is_sibling() const { return subject_.role == Role::sibling; }
  bool is_running() const { return participant_ != nullptr; }
  const GuidPrefix& prefix() const { return participant_->prefix(); }
  const RtpsParticipant& participant() const { return *participant_; }
  const std::vector<std::unique_ptr<Endpoint>>& endpoints() const { return endpoints_; }
  const Cost& cost() const { return cost_; }
  const Locator& address() const { return address_; }
  const std::map<Code, std::uint64_t>& events() const { return events_; }

  /// Starts the participant. `name` is the one whose GUID an impostor takes.
  void start(const GuidPrefix& name = {});
  /// Ends the participant. If `says_so`, it disposes itself first.
  void stop(bool says_so);
  void receive(const Datagram& datagram);
  void advance(MonotonicTime by);
  /// Sets its calendar.
  void set_calendar(seconds by) { clock_.set(clock_.calendar_seconds() + by); }
  /// Makes it do nothing until then. Datagrams that arrive wait in its socket.
  void sleep_until(MonotonicTime when) { asleep_until_ = when; }
  void write(Endpoint& endpoint);
  /// Adds a writer or reader of any topic.
  void add_endpoint(std::string_view topic, bool writes);
  void remove_endpoint(std::size_t index);
  /// Adds a durable writer that has used up `numbers` and holds the first and the last of them. It
  /// takes the place of the node's readers of the topic, which would get each sample at once.
  void add_sparse_writer(std::string_view topic, std::int64_t numbers);
  void add_durable_reader(std::string_view topic, bool reliable);

 private:
  /// The plugins, which end after their participant.
  struct Plugins {
    std::unique_ptr<spi::Authentication> authentication;
    std::unique_ptr<spi::AccessControl> access_control;
    std::unique_ptr<spi::Cryptography> cryptography;
  };
  static constexpr std::size_t kMaxInSocket = 256;

  void send(BytesView message, std::span<const Locator> to) override;
  void raise(const Event& event) override;
  void make_plugins(const GuidPrefix& name);
  ParticipantConfig config(const GuidPrefix& prefix);
  void call(std::size_t octets, const std::function<void()>& what);
  Bytes payload_of(const Guid& writer, SequenceNumber number);
  void add_endpoint(const End& end);

  const Surroundings& around_;
  const Subject& subject_;
  const Locator address_;
  Dice dice_;
  ManualClock clock_{pki::kNow};
  SeededRandom random_;
  Plugins plugins_;
  std::vector<std::unique_ptr<Endpoint>> endpoints_;
  std::unique_ptr<RtpsParticipant> participant_;
  Cost cost_;
  MonotonicTime asleep_until_{};
  std::vector<Datagram> in_socket_;
  std::map<Code, std::uint64_t> events_;
  bool writes_for_honest_ = false;  ///< true while it writes a sample whose readers are all honest
  std::size_t handshakes_ = 0;      ///< the number that the present call has begun
};

}  // namespace ddssec::rtps::sim
