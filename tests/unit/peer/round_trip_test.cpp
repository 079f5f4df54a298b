// The roles ping and pong with another side that matches late: nothing is lost, and no side waits
// for ever.
#include <thread>

#include <gtest/gtest.h>

#include "programs/peer/session.hpp"
#include "tests/support/silent.hpp"

namespace ddssec::peer {
namespace {

using namespace std::chrono_literals;

// The other side, played by the test.
struct Other {
  SystemClock clock;
  SystemRandom random;
  test::Silent events;
  std::unique_ptr<rtps::DomainParticipant> participant;
  rtps::Qos qos = rtps::default_writer_qos();

  explicit Other(std::int32_t domain) {
    participant = *rtps::DomainParticipant::create(
        {.domain_id = domain, .interfaces = {"127.0.0.1"}, .multicast = false},
        PluginServices{clock, random, events});
    qos.history.kind = rtps::HistoryKind::keep_all;
  }
  rtps::DataWriter<Blob>& writer(const char* topic) {
    return **participant->create_publisher().create_datawriter<Blob>(
        **participant->create_topic<Blob>(topic), qos);
  }
  rtps::DataReader<Blob>& reader(const char* topic) {
    return **participant->create_subscriber().create_datareader<Blob>(
        **participant->create_topic<Blob>(topic), qos);
  }
};

// Runs a role in a thread of its own.
class Running {
 public:
  Running(int (*role)(Session&), std::int32_t domain) : session_(options(domain)) {
    EXPECT_TRUE(session_.open());
    thread_ = std::thread([this, role] { code_ = role(session_); });
  }
  ~Running() { end(); }
  int end() {
    if (thread_.joinable()) thread_.join();
    return code_;
  }

 private:
  static Options options(std::int32_t domain) {
    Options out;
    out.domain = domain;
    out.count = 20;
    out.timeout = 20;
    return out;
  }
  Session session_;
  int code_ = -1;
  std::thread thread_;
};

template <class F>
bool eventually(F&& f) {
  for (int i = 0; i < 2000 && !f(); ++i) std::this_thread::sleep_for(5ms);
  return f();
}

// A volatile writer's samples do not reach a reader that has not matched yet.
TEST(RoundTrip, UnheardPing_IsSentAgain) {
  Other other(70);
  auto& pings = other.reader("PerfPing");
  auto& pongs = other.writer("PerfPong");
  Running ping(run_ping, 70);
  bool first = true;
  std::uint32_t answered = 0;
  rtps::Samples<Blob> samples;
  ASSERT_TRUE(eventually([&] {
    pings.wait_for_unread(20ms);
    EXPECT_TRUE(pings.take(samples));
    for (const auto& sample : samples) {
      if (!sample.info.valid_data || std::exchange(first, false)) continue;
      EXPECT_TRUE(pongs.write(sample.data));
      // A side that gets a ping twice answers it twice.
      const bool twice = answered++ < 3;
      EXPECT_TRUE(!twice || pongs.write(sample.data));
    }
    return answered >= 220;
  }));
  EXPECT_EQ(ping.end(), kDone);
}

TEST(RoundTrip, PingBeforeThePongsAreRead_IsAnsweredThen) {
  Other other(71);
  auto& pings = other.writer("PerfPing");
  Running pong(run_pong, 71);
  ASSERT_TRUE(eventually([&] { return matched_count(pings) > 0; }));
  std::this_thread::sleep_for(100ms);
  ASSERT_TRUE(pings.write({7, 0, 0, Bytes(10, 1)}));
  ASSERT_TRUE(pings.wait_for_acknowledgments(10s));
  auto& pongs = other.reader("PerfPong");
  ASSERT_TRUE(pongs.wait_for_unread(10s));
  EXPECT_EQ(pongs.take_next_sample()->data.seq, 7u);
  other.participant.reset();
  EXPECT_EQ(pong.end(), kDone);
}

}  // namespace
}  // namespace ddssec::peer
