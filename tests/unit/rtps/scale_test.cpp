// The cost of discovery for many endpoints, measured in work and not in time. This program is built
// with a call at every branch of the sources that tests/unit/rtps/CMakeLists.txt lists.
#include <gtest/gtest.h>

#include "rtps/dcps/liveliness.hpp"
#include "tests/unit/rtps/participant_fixture.hpp"
#include "wire/heartbeat_frag.hpp"

namespace {
std::uint64_t work = 0;
}
extern "C" void __sanitizer_cov_trace_pc();
void __sanitizer_cov_trace_pc() { ++work; }

namespace ddssec::rtps {
namespace {

using std::chrono::milliseconds;

template <class F>
std::uint64_t work_of(F&& f) {
  const auto before = work;
  f();
  return work - before;
}

// Writers of one participant and readers of another one, each pair on a topic of its own.
struct Pairs {
  Qos reader_qos = default_reader_qos();
  testing::socketless::Node a{1}, b{2};
  testing::socketless::World world{{&a, &b}};
  std::vector<Guid> writers, readers;
  std::int64_t asked = 0;  // asked for the next tick, as dcps does after each change

  void create(int count) {
    for (int i = 0; i < count; ++i) {
      const auto request = [&](const Qos& qos) {
        return EndpointDescription{"Topic" + std::to_string(i), "Type", qos, true};
      };
      writers.push_back(
          *a.participant.create_writer(request(default_writer_qos()), a.listener, world.now));
      readers.push_back(*b.participant.create_reader(request(reader_qos), b.listener, world.now));
      asked += a.participant.next_tick().count() + b.participant.next_tick().count();
    }
  }
  void remove() {
    for (const auto& guid : writers) a.participant.remove(guid, world.now);
    for (const auto& guid : readers) b.participant.remove(guid, world.now);
    world.run(5);
    EXPECT_EQ(a.participant.remote_participants().endpoint(readers.back()), nullptr);
    EXPECT_EQ(b.participant.remote_participants().endpoint(writers.back()), nullptr);
  }
  bool run_until_matched(int count) {
    for (int i = 0; i < 1000 && a.listener.matched + b.listener.matched < 2 * count; ++i)
      world.run(1);
    return a.listener.matched == count && b.listener.matched == count;
  }
  void write() {
    Change change;
    change.payload = Payload::copy_of(Bytes(64));
    a.participant.local_endpoints().writer(writers.back())->write(std::move(change), world.now);
    world.run(1);
  }
};

struct Work {
  std::uint64_t create, match, idle, write, late, remove, end;
};

Work work_of_pairs(int count) {
  Work out{};
  Pairs pairs;
  pairs.world.run(10);
  out.create = work_of([&] { pairs.create(count); });
  out.match = work_of([&] { EXPECT_TRUE(pairs.run_until_matched(count)); });
  pairs.world.run(100);
  out.idle = work_of([&] { pairs.world.run(100); });
  out.write = work_of([&] { pairs.write(); });
  EXPECT_EQ(pairs.b.listener.changes.size(), 1u);
  out.remove = work_of([&] { pairs.remove(); });
  // The endpoints exist before the participants meet, and then one participant leaves.
  Pairs late;
  late.create(count);
  out.late = work_of([&] { EXPECT_TRUE(late.run_until_matched(count)); });
  out.end = work_of([&] {
    late.a.participant.leave();
    late.world.run(2);
  });
  EXPECT_EQ(late.b.participant.remote_participants().size(), 0u);
  return out;
}

TEST(Scale, TheWorkOfAnEndpoint_DoesNotGrowWithTheirNumber) {
  ASSERT_GT(work_of([] { Pairs pairs; }), 0u) << "built without a call at every branch";
  constexpr int kFew = 250, kMany = 5000;
  const auto few = work_of_pairs(kFew), many = work_of_pairs(kMany);
  // A search in n log n, and messages about many endpoints, add a little.
  const auto expect_alike = [&](const char* what, std::uint64_t Work::*part, int in_few,
                                int in_many) {
    const auto one = static_cast<double>(few.*part) / in_few;
    const auto other = static_cast<double>(many.*part) / in_many;
    EXPECT_LT(other, 1.5 * one) << what << ": " << one << " becomes " << other;
  };
  expect_alike("create", &Work::create, kFew, kMany);
  expect_alike("match", &Work::match, kFew, kMany);
  expect_alike("match what was there before", &Work::late, kFew, kMany);
  expect_alike("remove", &Work::remove, kFew, kMany);
  expect_alike("lose a participant", &Work::end, kFew, kMany);
  expect_alike("a second without anything", &Work::idle, 1, 1);
  expect_alike("one sample", &Work::write, 1, 1);
}

// Does not ask to be notified of each assertion.
struct Quiet final : testing::socketless::Listener {
  void on_signal(const Guid&, std::shared_ptr<LivelinessSignal>) override {}
};

// Returns the work that a datagram of 20 octets causes for a reader of so many writers with a
// finite lease.
std::uint64_t work_of_a_sign_of_life(int writers) {
  Quiet reader;  // it outlives its endpoint
  testing::socketless::Node a{1}, b{2};
  testing::socketless::World world{{&a, &b}};
  auto offered = default_writer_qos();
  offered.liveliness = {LivelinessKind::automatic, Duration{{100, 0}}};
  EXPECT_TRUE(b.participant.create_reader({"Topic", "Type", default_reader_qos(), true}, reader,
                                          world.now));
  for (int i = 0; i < writers; ++i)
    EXPECT_TRUE(
        a.participant.create_writer({"Topic", "Type", offered, true}, a.listener, world.now));
  for (int i = 0; i < 1000 && reader.matched < writers; ++i) world.run(1);
  EXPECT_EQ(reader.matched, writers);
  auto message = testing::message({});
  std::ranges::copy(a.participant.prefix().octets, message.begin() + 8);
  return work_of([&] { b.participant.receive(message, world.now); });
}

// Otherwise each datagram would cost 16 ms with 2000 writers, and about 1.1 s at the bound of
// 16,384.
TEST(Scale, ASignOfLife_CostsTheSameForAnyNumberOfWriters) {
  const auto few = work_of_a_sign_of_life(10), many = work_of_a_sign_of_life(1000);
  EXPECT_LT(many, 2 * few);
}

template <class Set>
Set full_set() {
  Set out({1});
  for (std::uint32_t number = 1; number <= 256; ++number) out.insert({number});
  return out;
}

// Returns the work for a datagram of each kind that names one of so many pairs of endpoints.
std::map<std::string, std::uint64_t> work_of_datagrams(int count) {
  Pairs pairs;
  pairs.reader_qos.reliability.kind = ReliabilityKind::reliable;
  pairs.create(count);
  EXPECT_TRUE(pairs.run_until_matched(count));
  pairs.write();
  pairs.world.run(100);
  std::map<std::string, std::uint64_t> out;
  const auto send = [&](const char* kind, const testing::socketless::Node& from,
                        testing::socketless::Node& to, const auto& submessage) {
    auto datagram = testing::message({testing::written(submessage)});
    std::ranges::copy(from.participant.prefix().octets, datagram.begin() + 8);
    out[kind] = work_of([&] { to.participant.receive(datagram, pairs.world.now); });
    pairs.world.run(5);
  };
  const auto writer = pairs.writers.back().entity, reader = pairs.readers.back().entity;
  const Bytes octets(64);
  auto &a = pairs.a, &b = pairs.b;
  send("HEARTBEAT", a, b, Heartbeat{kEntityIdUnknown, writer, {1}, {1'000'000}, 1000});
  send("GAP", a, b, Gap{kEntityIdUnknown, writer, {1}, full_set<SequenceNumberSet>()});
  send("DATA", a, b, Data{kEntityIdUnknown, writer, {700}, {}, PayloadKind::data, octets});
  send("DATA_FRAG", a, b,
       DataFrag{kEntityIdUnknown, writer, {800}, {2}, 1, 64, 100'000, {}, false, octets});
  send("HEARTBEAT_FRAG", a, b, HeartbeatFrag{kEntityIdUnknown, writer, {800}, {1000}, 1000});
  send("ACKNACK", b, a, AckNack{reader, writer, full_set<SequenceNumberSet>(), 1000});
  send("NACK_FRAG", b, a, NackFrag{reader, writer, {1}, full_set<FragmentNumberSet>(), 1000});
  send("INFO_DST", a, b, InfoDestination{b.participant.prefix()});
  send("INFO_TS", a, b, InfoTimestamp{});
  send("DATA of an unknown writer", a, b,
       Data{kEntityIdUnknown, {{9, 9, 9, 2}}, {1}, {}, PayloadKind::data, octets});
  return out;
}

TEST(Scale, ADatagramOfEachKind_CostsTheSameForAnyNumberOfEndpoints) {
  const auto few = work_of_datagrams(10), many = work_of_datagrams(1000);
  // Each kind does more than one that is dropped at once.
  for (const auto* kind : {"HEARTBEAT", "ACKNACK", "DATA"})
    EXPECT_GT(few.at(kind), few.at("DATA of an unknown writer")) << kind;
  // A search in log n adds a little. A loop over all pairs would add at least 990.
  for (const auto& [kind, work] : few)
    EXPECT_LT(many.at(kind), work + work / 2 + 100)
        << kind << ": " << work << " becomes " << many.at(kind);
}

// Returns the work for a change of the keys of one endpoint among so many.
std::uint64_t work_of_a_key_change(int count) {
  testing::socketless::Node::Post post;
  test::RecordedEvents events;
  Quiet listener;  // it outlives its endpoints
  ParticipantCore core(testing::socketless::Node::config(1, 0, {}, 10), post, events);
  LocalEndpoints local(core, [](BuiltinTopic, Change&) { return true; });
  std::vector<LocalWriter*> writers;
  for (int i = 0; i < count; ++i) {
    writers.push_back(
        *local.create_writer({"Topic", "Type", default_writer_qos(), true}, listener));
    EXPECT_TRUE(local.create_reader({"Topic", "Type", default_reader_qos(), true}, listener));
  }
  auto& changed = *writers[writers.size() / 2];
  const auto reader = [](int number) {
    return Guid{
        GuidPrefix::from(Bytes(12, 9)),
        {{static_cast<std::uint8_t>(number >> 8), static_cast<std::uint8_t>(number), 0, 7}}};
  };
  for (int i = 0; i < count; ++i) changed.protocol->match({reader(i), true, false, {}}, core.now);
  return work_of(
      [&] { local.note_key_change(changed.data.guid.entity, reader(0), KeyChange::revised); });
}

TEST(Scale, AKeyChangeOfOneEndpoint_CostsTheSameForAnyNumberOfThem) {
  const auto few = work_of_a_key_change(10), many = work_of_a_key_change(1000);
  EXPECT_LT(many, few + few / 2 + 100);
}

// Returns the work for a HEARTBEAT to a reader that holds so many samples, because the first one is
// missing.
std::uint64_t work_of_a_heartbeat(int count) {
  Pairs pairs;
  pairs.reader_qos.reliability.kind = ReliabilityKind::reliable;
  pairs.create(1);
  EXPECT_TRUE(pairs.run_until_matched(1));
  pairs.write();
  pairs.world.run(10);
  const auto send = [&](const auto& submessage) {
    auto datagram = testing::message({testing::written(submessage)});
    std::ranges::copy(pairs.a.participant.prefix().octets, datagram.begin() + 8);
    return work_of([&] { pairs.b.participant.receive(datagram, pairs.world.now); });
  };
  const auto writer = pairs.writers.back().entity;
  const Bytes octets(8);
  for (int i = 0; i < count; ++i)
    send(Data{kEntityIdUnknown, writer, {3 + i}, {}, PayloadKind::data, octets});
  return send(Heartbeat{kEntityIdUnknown, writer, {1}, {3 + count}, 1000});
}

TEST(Scale, AHeartbeat_CostsTheSameForAnyNumberOfEarlySamples) {
  const auto few = work_of_a_heartbeat(500), many = work_of_a_heartbeat(10'000);
  EXPECT_LT(many, few + few / 2 + 100);
}

struct CrowdWork {
  double match, part;  // for each endpoint
};

// Returns the work for so many writers of one participant on a topic that we read, and readers on
// one that we write.
CrowdWork work_of_a_crowd(int count) {
  Quiet own, theirs;  // they outlive their endpoints
  testing::socketless::Node a{1}, b{2};
  testing::socketless::World world{{&a, &b}};
  auto offered = default_writer_qos();
  offered.liveliness = {LivelinessKind::automatic, Duration{{100, 0}}};
  const auto request = [](const char* topic, const Qos& qos) {
    return EndpointDescription{topic, "Type", qos, true};
  };
  EXPECT_TRUE(a.participant.create_writer(request("Down", default_writer_qos()), own, world.now));
  EXPECT_TRUE(a.participant.create_reader(request("Up", default_reader_qos()), own, world.now));
  world.run(10);
  for (int i = 0; i < count; ++i) {
    EXPECT_TRUE(b.participant.create_writer(request("Up", offered), theirs, world.now));
    EXPECT_TRUE(
        b.participant.create_reader(request("Down", default_reader_qos()), theirs, world.now));
  }
  CrowdWork out{};
  const int all = 2 * count;
  out.match = static_cast<double>(work_of([&] {
                for (int i = 0; i < 1000 && own.matched < all; ++i) world.run(1);
              })) /
              count;
  EXPECT_EQ(own.matched, all);
  b.participant.leave();
  out.part = static_cast<double>(work_of([&] { world.run(2); })) / count;
  EXPECT_EQ(own.matched, 0);
  return out;
}

// Otherwise matching 16,000 readers of one participant cost 52 s of CPU, and its end 48 s in one
// call.
TEST(Scale, AnEndpointOnOneTopic_CostsTheSameForAnyNumberOfThem) {
  const auto few = work_of_a_crowd(50), many = work_of_a_crowd(1000);
  EXPECT_LT(many.match, 2 * few.match) << few.match << " becomes " << many.match;
  EXPECT_LT(many.part, 2 * few.part) << few.part << " becomes " << many.part;
}

// Returns the work of a reader with so many writers for an assertion, and for the time at which the
// first lease would end.
std::uint64_t work_of_leases(int writers) {
  const auto signal = std::make_shared<LivelinessSignal>(milliseconds(0));
  LivelinessMonitor monitor;
  for (int i = 0; i < writers; ++i) {
    const Guid guid{GuidPrefix::from(Bytes(12, 1)),
                    {{static_cast<std::uint8_t>(i >> 8), static_cast<std::uint8_t>(i), 0, 2}}};
    monitor.add(guid, Duration{{1, 0}}, milliseconds(i));
    monitor.follow(guid, signal);
  }
  return work_of([&] {
    signal->assert_at(milliseconds(1));
    EXPECT_EQ(monitor.next_tick(), milliseconds(1000));
    monitor.expire(milliseconds(999), {});
    monitor.note_alive({GuidPrefix::from(Bytes(12, 1)), {{0, 5, 0, 2}}}, milliseconds(999));
  });
}

TEST(Scale, AnAssertion_CostsTheSameForAnyNumberOfLeases) {
  EXPECT_LT(work_of_leases(10'000), 3 * work_of_leases(10)) << "a search in log n";
}

}  // namespace
}  // namespace ddssec::rtps
