// A writer and a reader over a network that loses, duplicates and reorders messages.
#pragma once

#include <deque>
#include <random>

#include "rtps/reliability/stateful_reader.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"
#include "wire/entity_ids.hpp"

namespace ddssec::rtps::of_reliability {

using std::chrono::milliseconds;

inline const GuidPrefix kA = GuidPrefix::from(Bytes(12, 0xaa));
inline const GuidPrefix kB = GuidPrefix::from(Bytes(12, 0xbb));
inline const Locator kHere = *Locator::parse("127.0.0.1", 1);

/// Two ends. What one of them sends waits until the test carries it over.
struct Network {
  struct End final : Transport {
    std::deque<Bytes> sent;
    void send(BytesView message, std::span<const Locator>) override {
      sent.push_back(to_bytes(message));
    }
  };
  End a, b;
  std::mt19937 random{1};
  int loss_percent = 0, duplicate_percent = 0;
  bool reorder = false;
  std::size_t messages = 0;

  bool chance(int percent) { return static_cast<int>(random() % 100) < percent; }
  template <class F>
  void carry(End& end, F&& receive) {
    auto waiting = std::exchange(end.sent, {});
    if (reorder) std::ranges::shuffle(waiting, random);
    for (const auto& message : waiting) {
      ++messages;
      if (chance(loss_percent)) continue;
      receive(message);
      if (chance(duplicate_percent)) receive(message);
    }
  }
};

struct Pair {
  Network net;
  MessageSender to_b{net.a, kA};
  MessageSender to_a{net.b, kB};
  StatefulWriter writer;
  std::vector<Change> delivered;
  std::size_t most = 1'000'000;  ///< above this, the reader's history is full
  StatefulReader reader;
  MonotonicTime now{};
  bool is_protected = true;  ///< all messages are protected, with keys of their senders

  explicit Pair(Qos offered = default_writer_qos(), bool reliable = true)
      : writer({kA, testing::kWriter}, offered, to_b),
        reader({kB, testing::kReader}, reliable, to_a, [this](Change& change) {
          if (delivered.size() >= most) return false;
          delivered.push_back(std::move(change));
          return true;
        }) {}

  void match(bool wants_history = false, bool reliable = true) {
    reader.match({writer.guid(), writer.qos().is_reliable(), {kHere}}, now);
    writer.match({reader.guid(), reliable, wants_history, {kHere}}, now);
  }
  SequenceNumber write(Bytes octets, std::optional<KeyHash> key = {}) {
    Change change;
    change.payload = Payload::copy_of(octets);
    change.key_hash = key;
    return writer.write(std::move(change), now);
  }
  void receive(const Bytes& message) {
    auto walker = *MessageReader::open(message);
    const auto from = walker.header().prefix;
    std::optional<Time> time;
    for (auto next = walker.next(); next && *next; next = walker.next()) {
      const auto& view = **next;
      switch (view.id) {
        case SubmessageId::data:
          reader.on_data(from, *read_data(view), time, {}, KeyAge::newest);
          break;
        case SubmessageId::data_frag:
          reader.on_data_frag(from, *read_data_frag(view), time, false, KeyAge::newest);
          break;
        case SubmessageId::heartbeat:
          reader.on_heartbeat(from, *read_heartbeat(view), is_protected, KeyAge::newest);
          break;
        case SubmessageId::gap:
          reader.on_gap(from, *read_gap(view), KeyAge::newest);
          break;
        case SubmessageId::acknack:
          writer.on_acknack(from, *read_acknack(view), now, is_protected, KeyAge::newest);
          break;
        case SubmessageId::nack_frag:
          writer.on_nack_frag(from, *read_nack_frag(view), now, is_protected, KeyAge::newest);
          break;
        default:
          break;
      }
    }
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      net.carry(net.a, [&](const Bytes& message) { receive(message); });
      net.carry(net.b, [&](const Bytes& message) { receive(message); });
      now += milliseconds(10);
      writer.tick(now);
      reader.tick(now);
    }
  }
  std::vector<std::int64_t> numbers() const {
    std::vector<std::int64_t> out;
    for (const auto& change : delivered) out.push_back(change.sequence_number.value);
    return out;
  }
};

inline Qos keep_all() {
  auto qos = default_writer_qos();
  qos.history.kind = HistoryKind::keep_all;
  return qos;
}

}  // namespace ddssec::rtps::of_reliability
