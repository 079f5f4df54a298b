// Where discovery is protected, Cyclone DDS reports the end of a reader without protection. Such a
// report makes the writer ask the reader.
#include "rtps/participant/reader_presence.hpp"

#include <algorithm>

#include "rtps/participant/reader_end_checks.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr int kAnswerTimeout = ReaderEndChecks::kAnswerTimeout / 10ms;  // in steps

bool is_about(BytesView datagram, const EntityId& id) {
  return !std::ranges::search(datagram, id.octets).empty();
}

// Participant a writes and b reads.
struct ReaderPresenceTest : ::testing::Test {
  static constexpr Rules kRules{.discovery = kEncrypt};
  ReaderPresenceTest() : pair(kRules) {
    EXPECT_TRUE(pair.match());
    pair.world.filter = [this](const Node& from, Bytes datagram) {
      return is_cut_off && (&from == &pair.b || cuts_both) ? std::vector<Bytes>() : one(datagram);
    };
  }
  // Reports the end, as an attacker or Cyclone DDS itself does.
  void report_end(const Guid& endpoint) {
    Bytes buffer(64);
    SpanWriter out(buffer);
    write_endpoint_key(out, endpoint);
    const Data dispose{kSubscriptionsReader, kSubscriptionsWriter,
                       {++number},           {endpoint.octets(), {true, true}},
                       PayloadKind::key,     out.view()};
    pair.a->receive(forged(endpoint.prefix, dispose), pair.world.now);
  }
  int matched() { return pair.a.listener.matched; }
  std::size_t received() { return pair.b.listener.changes.size(); }
  bool acknowledged() { return pair.a->local_endpoints().writer(pair.writer)->all_acknowledged(); }
  // Returns the number of datagrams that a sends in that time.
  std::size_t sent_in(int steps, bool reported) {
    std::size_t count = 0;
    for (int i = 0; i < steps; ++i) {
      if (reported) report_end(pair.reader);
      count += pair.a.post.sent.size();
      pair.world.run(1);
    }
    return count;
  }

  Pair pair;
  bool is_cut_off = false, cuts_both = false;
  std::int64_t number = 0;
};

TEST_F(ReaderPresenceTest, ReaderThatAnswers_StaysMatched) {
  report_end(pair.reader);
  pair.world.run(2 * kAnswerTimeout);
  EXPECT_EQ(matched(), 1);
  EXPECT_FALSE(pair.a.events.has(Code::rtps_reader_silent));
  pair.write();
  EXPECT_TRUE(pair.world.run_until([&] { return received() == 1; }, 100));
}

TEST_F(ReaderPresenceTest, ManyReports_CostOneQuestionInFourSeconds) {
  const auto quiet = sent_in(2 * kAnswerTimeout, false);
  const auto reported = sent_in(2 * kAnswerTimeout, true);
  EXPECT_EQ(matched(), 1);
  EXPECT_LE(reported, quiet + 4);
}

TEST_F(ReaderPresenceTest, ReaderThatIsSilent_CountsAsEnded) {
  pair.world.run(20);
  is_cut_off = true;
  pair.write();
  report_end(pair.reader);
  pair.world.run(kAnswerTimeout - 20);
  EXPECT_EQ(matched(), 1);
  EXPECT_FALSE(acknowledged());
  pair.world.run(40);
  EXPECT_EQ(matched(), 0);
  EXPECT_TRUE(acknowledged()) << "nothing waits for it";
  EXPECT_EQ(pair.a.events.count(Code::rtps_reader_silent), 1);
  EXPECT_EQ(pair.a->remote_participants().size(), 1u) << "its participant stays";
}

// The report was forged while the reader could not be reached.
TEST_F(ReaderPresenceTest, SilentReaderIsInReachAgain_Matches) {
  is_cut_off = cuts_both = true;
  report_end(pair.reader);
  pair.world.run(kAnswerTimeout + 40);
  ASSERT_EQ(matched(), 0);
  is_cut_off = false;
  EXPECT_TRUE(pair.world.run_until([&] { return matched() == 1; }, 2 * kAnswerTimeout));
  pair.write();
  EXPECT_TRUE(pair.world.run_until([&] { return received() == 1; }, 100));
}

// The answer was recorded before the reader fell silent.
TEST_F(ReaderPresenceTest, RepeatedAnswer_DoesNotBringItBack) {
  Bytes recorded;
  pair.world.filter = [&](const Node& from, Bytes datagram) {
    if (!is_cut_off && &from == &pair.b && is_about(datagram, pair.writer.entity))
      recorded = datagram;
    return is_cut_off && &from == &pair.b ? std::vector<Bytes>() : one(datagram);
  };
  pair.write();
  pair.world.run(100);
  ASSERT_FALSE(recorded.empty());
  is_cut_off = true;
  report_end(pair.reader);
  pair.world.run(kAnswerTimeout + 40);
  ASSERT_EQ(matched(), 0);
  pair.a->receive(recorded, pair.world.now);
  EXPECT_EQ(matched(), 0);
}

// If only payloads are protected, anyone can send a HEARTBEAT or an ACKNACK. A count that no honest
// message reaches does not keep the reader from being asked, or its answer from being accepted.
struct ForgedCount : ReaderPresenceTest, ::testing::WithParamInterface<bool> {
  void forge() {
    constexpr std::int32_t kFarAhead = 0x40000000;
    if (GetParam())
      return pair.b->receive(
          forged(pair.a->prefix(),
                 Heartbeat{kEntityIdUnknown, pair.writer.entity, {1}, {0}, kFarAhead, true}),
          pair.world.now);
    pair.a->receive(forged(pair.b->prefix(), AckNack{pair.reader.entity, pair.writer.entity,
                                                     SequenceNumberSet({1}), kFarAhead, true}),
                    pair.world.now);
  }
};

TEST_P(ForgedCount, CountOfEitherSide_DoesNotMakeTheReaderSilent) {
  pair.world.run(20);
  forge();
  report_end(pair.reader);
  pair.world.run(2 * kAnswerTimeout);
  EXPECT_EQ(matched(), 1);
  EXPECT_FALSE(pair.a.events.has(Code::rtps_reader_silent));
}

TEST_P(ForgedCount, CountOfEitherSide_DoesNotKeepASilentReaderAway) {
  pair.world.run(20);
  forge();
  is_cut_off = cuts_both = true;
  report_end(pair.reader);
  pair.world.run(kAnswerTimeout + 40);
  ASSERT_EQ(matched(), 0);
  is_cut_off = false;
  EXPECT_TRUE(pair.world.run_until([&] { return matched() == 1; }, 2 * kAnswerTimeout));
}

INSTANTIATE_TEST_SUITE_P(Doubt, ForgedCount, ::testing::Bool());

TEST_F(ReaderPresenceTest, ReportOfAWriter_ChangesNothing) {
  pair.world.run(20);
  report_end(pair.writer);
  report_end({pair.b->prefix(), pair.writer.entity});
  pair.world.run(kAnswerTimeout + 40);
  EXPECT_EQ(matched(), 1);
}

// Otherwise a peer whose readers fall silent in turn would fill the writer's messages with MACs.
TEST(ReaderPresenceMacs, MacsOfASilentReader_AreLeftOutUntilItIsHeard) {
  Pair pair({.discovery = kEncrypt, .metadata = ProtectionKind::sign_with_origin_authentication});
  ASSERT_TRUE(pair.match());
  pair.world.run(100);
  bool is_cut_off = false;
  pair.world.filter = [&](const Node& from, Bytes datagram) {
    const bool drops = is_cut_off && &from == &pair.b && is_about(datagram, pair.reader.entity);
    return drops ? std::vector<Bytes>() : one(std::move(datagram));
  };
  const auto size_of_sample = [&] {
    pair.a.post.sent.clear();
    pair.write();
    const auto size = pair.a.post.sent.front().second.size();
    pair.world.run(20);
    return size;
  };
  const auto with_one = size_of_sample();
  Listener second;
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  ASSERT_TRUE(pair.b->create_reader(square(qos), second, pair.world.now));
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 2; }));
  pair.world.run(100);
  const auto with_both = size_of_sample();
  ASSERT_GT(with_both, with_one);
  is_cut_off = true;
  Bytes buffer(64);
  SpanWriter out(buffer);
  write_endpoint_key(out, pair.reader);
  pair.a->receive(forged(pair.b->prefix(), Data{kSubscriptionsReader,
                                                kSubscriptionsWriter,
                                                {1},
                                                {pair.reader.octets(), {true, true}},
                                                PayloadKind::key,
                                                out.view()}),
                  pair.world.now);
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 1; }, 600));
  EXPECT_EQ(size_of_sample(), with_one);
  is_cut_off = false;
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 2; }, 4000));
  EXPECT_EQ(size_of_sample(), with_both);
}

TEST_F(ReaderPresenceTest, EndThatIsProtected_EndsAtOnce) {
  is_cut_off = true;
  report_end(pair.reader);
  pair.world.run(kAnswerTimeout + 40);
  ASSERT_EQ(matched(), 0);
  is_cut_off = false;
  pair.b->remove(pair.reader, pair.world.now);
  pair.world.run(100);
  EXPECT_EQ(matched(), 0);
  EXPECT_FALSE(pair.a->local_endpoints().writer(pair.writer)->readers().contains(pair.reader));
}

}  // namespace
}  // namespace ddssec::rtps
