// The number of messages that a pair needs: small samples share them, and readers answer only when
// they are asked.
#include "rtps/reliability/message_sender.hpp"

#include <gmock/gmock.h>

#include "rtps/participant/rtps_participant.hpp"
#include "rtps/transport/event_loop.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

const GuidPrefix kA = GuidPrefix::from(Bytes(12, 0xaa));
const GuidPrefix kB = GuidPrefix::from(Bytes(12, 0xbb));
const Locator kHere = *Locator::parse("127.0.0.1", 1);

struct Recorder final : Transport {
  std::vector<Bytes> sent;
  std::vector<std::uint8_t> calls;  // the DSCP of each call of send_all
  bool is_here = false;
  void send(BytesView message, std::span<const Locator>) override {
    sent.push_back(to_bytes(message));
  }
  void send_all(const OutgoingMessages& out) override {
    calls.push_back(out.dscp);
    Transport::send_all(out);
  }
  bool stays_here(const Locator&) const override { return is_here; }
};

std::vector<SubmessageView> submessages(const Bytes& octets, SubmessageId id) {
  std::vector<SubmessageView> out;
  auto walker = *MessageReader::open(octets);
  for (auto next = walker.next(); next && *next; next = walker.next())
    if ((*next)->id == id) out.push_back(**next);
  return out;
}

std::size_t count(const std::vector<Bytes>& messages, SubmessageId id) {
  std::size_t out = 0;
  for (const auto& octets : messages) out += submessages(octets, id).size();
  return out;
}

// Counts the heartbeats that require an answer.
std::size_t heartbeats_without_final(const std::vector<Bytes>& messages) {
  std::size_t out = 0;
  for (const auto& octets : messages)
    for (const auto& view : submessages(octets, SubmessageId::heartbeat))
      out += read_heartbeat(view)->is_final ? 0 : 1;
  return out;
}

Qos keep_all(std::int32_t most = kLengthUnlimited) {
  auto qos = default_writer_qos();
  qos.history.kind = HistoryKind::keep_all;
  qos.resource_limits.max_samples = most;
  return qos;
}

class Packing : public ::testing::Test {
 protected:
  explicit Packing(const Qos& qos = keep_all()) : writer({kA, testing::kWriter}, qos, sender) {
    sender.allow_delayed_flush();
    writer.match({{kB, testing::kReader}, true, false, {kHere}}, now);
    transport.sent.clear();
  }
  void write(std::size_t size = 64) {
    Change change;
    change.payload = Payload::copy_of(Bytes(size));
    writer.write(std::move(change), now);
  }
  void write_quickly(int samples, std::size_t size = 64) {
    for (int i = 0; i < samples; ++i) {
      now += microseconds(1);
      write(size);
    }
  }

  Recorder transport;
  MessageSender sender{transport, kA};
  MonotonicTime now = milliseconds(50);
  StatefulWriter writer;
};

TEST_F(Packing, SmallSamplesInQuickSuccession_ShareMessages) {
  write_quickly(200);
  EXPECT_LT(transport.sent.size(), 10u);
  EXPECT_LE(sender.flush_by(), now + WritePace::kLinger);
  sender.flush();
  EXPECT_EQ(count(transport.sent, SubmessageId::data), 200u);
  EXPECT_EQ(sender.flush_by(), kNever);
  for (const auto& octets : transport.sent) EXPECT_LE(octets.size(), MessageSender::kMaxMessage);
}

TEST_F(Packing, SamplesWithoutALingerTime_LeaveAtOnce) {
  Recorder other;
  MessageSender strict(other, kA);
  StatefulWriter at_once({kA, testing::kWriter}, keep_all(), strict);
  at_once.match({{kB, testing::kReader}, true, false, {kHere}}, now);
  other.sent.clear();
  for (int i = 0; i < 20; ++i) at_once.write({}, now += microseconds(1));
  EXPECT_EQ(other.sent.size(), 20u);
}

TEST_F(Packing, SlowWritesAndAnswers_AreNotKeptWaiting) {
  for (int i = 0; i < 20; ++i) {
    now += microseconds(60);
    write();
    EXPECT_EQ(transport.sent.size(), static_cast<std::size_t>(i + 1));
  }
  for (int i = 20; i < 40; ++i) {
    now += microseconds(1);
    sender.note_sample();
    write();
    EXPECT_EQ(transport.sent.size(), static_cast<std::size_t>(i + 1));
  }
}

TEST_F(Packing, WhatOneEventBringsAbout_SharesMessages) {
  const auto other = *Locator::parse("127.0.0.1", 2);
  const auto speak = [&](const Locator& to) {
    sender.add({kB, {&to, 1}}, AckNack{testing::kReader, testing::kWriter, {}, 1, true});
    sender.flush();
  };
  {
    const MessageSender::GatheringScope event(sender);
    {
      const MessageSender::GatheringScope part_of_it(sender);
      for (int i = 0; i < 5; ++i) speak(kHere);
    }
    EXPECT_TRUE(transport.sent.empty());
    speak(other);
    EXPECT_EQ(transport.sent.size(), 1u) << "another address";
    speak(kHere);
    sender.flush_now();
    EXPECT_EQ(transport.sent.size(), 3u);
  }
  EXPECT_EQ(transport.sent.size(), 3u);
  EXPECT_EQ(count({transport.sent.front()}, SubmessageId::acknack), 5u);
  EXPECT_EQ(count({transport.sent.front()}, SubmessageId::info_destination), 1u);
}

TEST_F(Packing, LargeSamples_DoNotWait) {
  write_quickly(20, 8192);
  EXPECT_EQ(transport.sent.size(), 20u);
}

TEST_F(Packing, WhatWaits_LeavesBeforeItsReaderOrItsWriterDoes) {
  write_quickly(20);
  writer.unmatch({kB, testing::kReader});
  EXPECT_EQ(count(transport.sent, SubmessageId::data), 20u);
  Recorder other;
  MessageSender lingering(other, kA);
  lingering.allow_delayed_flush();
  {
    StatefulWriter dying({kA, testing::kWriter}, keep_all(), lingering);
    dying.match({{kB, testing::kReader}, true, false, {kHere}}, now);
    for (int i = 0; i < 20; ++i) dying.write({}, now += microseconds(1));
  }
  EXPECT_EQ(count(other.sent, SubmessageId::data), 20u);
}

TEST_F(Packing, Readers_AreAskedNowAndThen) {
  for (int i = 0; i < 1024; ++i) {
    now += microseconds(100);
    write();
  }
  EXPECT_EQ(count(transport.sent, SubmessageId::data), 1024u);
  EXPECT_EQ(heartbeats_without_final(transport.sent), 4u);
  const auto heartbeats = count(transport.sent, SubmessageId::heartbeat);
  EXPECT_GE(heartbeats, 100u) << "each millisecond tells what there is";
  EXPECT_LE(heartbeats, 110u);
}

TEST_F(Packing, WaitForAcknowledgments_AsksAtOnce) {
  write();
  EXPECT_EQ(heartbeats_without_final(transport.sent), 0u);
  writer.request_acknowledgments();
  EXPECT_EQ(heartbeats_without_final(transport.sent), 1u);
  writer.on_acknack(kB, {testing::kReader, testing::kWriter, SequenceNumberSet({2}), 1, true}, now,
                    true, KeyAge::newest);
  transport.sent.clear();
  writer.request_acknowledgments();
  EXPECT_TRUE(transport.sent.empty());
}

class SmallHistory : public Packing {
 protected:
  SmallHistory() : Packing(keep_all(8)) {}
};

TEST_F(SmallHistory, FillingUp_AsksBeforeAndWhenItIsFull) {
  write_quickly(8);
  EXPECT_FALSE(writer.history().has_room(64));
  EXPECT_EQ(count(transport.sent, SubmessageId::data), 8u);
  EXPECT_EQ(heartbeats_without_final(transport.sent), 4u);
  EXPECT_EQ(heartbeats_without_final({transport.sent.back()}), 1u);
}

TEST_F(Packing, FragmentsOfASample_ShareCallsOfTheTransport) {
  transport.calls.clear();
  write(1 << 20);
  constexpr std::size_t kFragments = 74;
  EXPECT_EQ(count(transport.sent, SubmessageId::data_frag), kFragments);
  EXPECT_EQ(transport.sent.size(), kFragments);
  EXPECT_EQ(transport.calls.size(), kFragments / MessageSender::kMaxWaiting + 1);
  std::uint32_t last = 0;
  for (const auto& octets : transport.sent)
    for (const auto& view : submessages(octets, SubmessageId::data_frag))
      EXPECT_EQ(read_data_frag(view)->first.value, ++last);
}

TEST_F(Packing, ToThisMachine_MessagesAreAsLargeAsADatagram) {
  transport.is_here = true;
  write_quickly(10, 8192);
  transport.sent.clear();
  write_quickly(70, 8192);
  sender.flush();
  EXPECT_GE(count(transport.sent, SubmessageId::data), 70u);
  EXPECT_LE(transport.sent.size(), 20u) << "a question each 128 KiB leaves at once";
  transport.sent.clear();
  transport.calls.clear();
  write(1 << 20);
  EXPECT_EQ(transport.sent.size(), 19u) << "four of the 74 fragments in each";
  EXPECT_EQ(transport.calls.size(), 10u) << "no more octets in a call than elsewhere";
  for (const auto& octets : transport.sent) EXPECT_LE(octets.size(), MessageSender::kMaxDatagram);
}

// Protects messages like a plugin that needs a MAC for each of many receivers.
struct Wrapping final : SendProtection {
  explicit Wrapping(std::size_t receivers) : macs(receivers * 20) {}
  Levels levels(const EntityId&) const override {
    return {.message = Wrap::participant_key, .message_room = macs};
  }
  Result<std::size_t> protect_payload(const EntityId&, BytesView, MutableBytes) override {
    return fail(Code::length_out_of_range);
  }
  Result<std::size_t> protect_submessage(const EntityId&, const Guid&, BytesView,
                                         MutableBytes) override {
    return fail(Code::length_out_of_range);
  }
  Result<std::size_t> protect_message(Wrap, const GuidPrefix&, BytesView plain,
                                      MutableBytes out) override {
    if (plain.size() + macs > out.size()) return fail(Code::length_out_of_range);
    std::ranges::copy(plain, out.begin());
    return plain.size() + macs;
  }
  void on_unprotectable(const Error&) override { ++refused; }
  const std::size_t macs;
  int refused = 0;
};

// Messages of four fragments must fit with 297 receivers and more, too.
TEST_F(Packing, ProtectedMessagesToThisMachine_LeaveRoomForTheirMacs) {
  for (const std::size_t receivers : {200u, 300u, 480u}) {
    Wrapping protection(receivers);
    transport.is_here = true;
    sender.protect_with(protection);
    for (const auto size : {100, 8192, 14'300, 14'700, 200'000}) {
      transport.sent.clear();
      write_quickly(50, static_cast<std::size_t>(size));
      sender.flush();
      EXPECT_EQ(protection.refused, 0) << size;
      EXPECT_GE(count(transport.sent, SubmessageId::data) +
                    count(transport.sent, SubmessageId::data_frag),
                50u)
          << size;
      if (size < 14'000) {
        EXPECT_LT(transport.sent.size(), 50u);
      }
    }
    sender.flush_now();
  }
}

TEST_F(Packing, WhatIsForOthers_DoesNotWaitWithAFullMessage) {
  const Locator there = *Locator::parse("127.0.0.1", 2);
  const Locator one[] = {kHere}, other[] = {there};
  const Bytes octets(10'000);
  const auto data = [&](std::int64_t number) {
    return Data{{}, testing::kWriter, {number}, {}, PayloadKind::data, octets};
  };
  sender.add({{}, one}, data(1));
  sender.add({{}, one}, data(2));
  EXPECT_TRUE(transport.sent.empty());
  sender.add({{}, other}, data(3));
  EXPECT_EQ(count(transport.sent, SubmessageId::data), 2u);
  sender.flush();
  EXPECT_EQ(count(transport.sent, SubmessageId::data), 3u);
}

class LatencyBudgetWriter : public Packing {
 protected:
  static Qos qos() {
    auto out = keep_all();
    out.latency_budget = Duration::from(milliseconds(10));
    return out;
  }
  LatencyBudgetWriter() : Packing(qos()) {}
};

TEST_F(LatencyBudgetWriter, SmallSamples_WaitForOthersWithinTheLatencyBudget) {
  const auto first = now;
  for (int i = 0; i < 8; ++i, now += milliseconds(1)) write();
  EXPECT_TRUE(transport.sent.empty());
  EXPECT_EQ(sender.flush_by(), first + milliseconds(10));
  sender.flush();
  EXPECT_EQ(transport.sent.size(), 1u);
  EXPECT_EQ(count(transport.sent, SubmessageId::data), 8u);
  write(8192);
  EXPECT_EQ(transport.sent.size(), 2u) << "large ones do not wait";
}

TEST_F(LatencyBudgetWriter, ABudget_MayChangeAndIsNeverLong) {
  auto changed = qos();
  changed.latency_budget = kDurationInfinite;
  writer.set_urgency(changed);
  write();
  EXPECT_EQ(sender.flush_by(), now + WritePace::kMaxBudget);
  sender.flush();
  changed.latency_budget = kDurationZero;
  writer.set_urgency(changed);
  now += milliseconds(1);
  write();
  EXPECT_EQ(transport.sent.size(), 2u);
}

TEST_F(Packing, ThePriorityOfAWriter_GoesWithItsMessages) {
  auto urgent = keep_all();
  urgent.transport_priority = 46;
  writer.set_urgency(urgent);
  StatefulWriter plain({kA, testing::kWriter}, keep_all(), sender);
  plain.match({{kB, testing::kReader}, true, false, {kHere}}, now);
  transport.calls.clear();
  write();
  plain.write({}, now);
  urgent.transport_priority = 1000;
  writer.set_urgency(urgent);
  write();
  EXPECT_THAT(transport.calls, ::testing::ElementsAre(46, 0, 63));
}

TEST(PackingReader, QuestionOrMissingSample_IsAnswered) {
  Recorder transport;
  MessageSender sender(transport, kB);
  StatefulReader reader({kB, testing::kReader}, true, sender, [](Change&) { return true; });
  reader.match({{kA, testing::kWriter}, true, {kHere}}, {});
  transport.sent.clear();
  std::int32_t number = 0;
  const auto heartbeat = [&](std::int64_t last, bool is_final) {
    reader.on_heartbeat(kA, {{}, testing::kWriter, {1}, {last}, ++number, is_final, false}, true,
                        KeyAge::newest);
    return std::exchange(transport.sent, {}).size();
  };
  const auto data = [&](std::int64_t at) {
    reader.on_data(kA, {{}, testing::kWriter, {at}, {}, PayloadKind::data, Bytes{1}}, {}, {},
                   KeyAge::newest);
  };
  data(1);
  EXPECT_EQ(heartbeat(1, true), 0u);
  EXPECT_EQ(heartbeat(1, false), 1u);
  data(3);
  EXPECT_EQ(heartbeat(3, true), 1u) << "2 is missing";
  data(2);
  EXPECT_EQ(heartbeat(3, true), 0u);
  EXPECT_EQ(heartbeat(4, true), 1u);
}

TEST(PackingReader, AFullReader_MissesNothing) {
  Recorder transport;
  MessageSender sender(transport, kB);
  StatefulReader reader({kB, testing::kReader}, true, sender, [](Change&) { return false; });
  reader.match({{kA, testing::kWriter}, true, {kHere}}, {});
  for (std::int64_t at = 1; at <= 3; ++at)
    reader.on_data(kA, {{}, testing::kWriter, {at}, {}, PayloadKind::data, Bytes{1}}, {}, {},
                   KeyAge::newest);
  transport.sent.clear();
  reader.on_heartbeat(kA, {{}, testing::kWriter, {1}, {3}, 1, true, false}, true, KeyAge::newest);
  EXPECT_TRUE(transport.sent.empty());
  reader.on_heartbeat(kA, {{}, testing::kWriter, {1}, {3}, 2, false, false}, true, KeyAge::newest);
  EXPECT_EQ(transport.sent.size(), 1u);
}

TEST(PackingLoop, ShortWaitAllowed_IsLessThanAMillisecond) {
  auto loop = *EventLoop::create();
  auto shortest = std::chrono::steady_clock::duration::max();
  for (int i = 0; i < 200; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    loop.wait(microseconds(100));
    const auto taken = std::chrono::steady_clock::now() - begin;
    EXPECT_GE(taken, microseconds(100));
    shortest = std::min(shortest, taken);
  }
  EXPECT_LT(shortest, microseconds(900));
}

}  // namespace
}  // namespace ddssec::rtps
