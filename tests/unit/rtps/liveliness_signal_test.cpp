// One assertion for all writers of a participant. Readers that wait for it are notified once.
#include "rtps/participant/liveliness_signal.hpp"

#include <gmock/gmock.h>

#include "rtps/participant/endpoint_listener.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

struct Waiting final : EndpointListener {
  void on_matched(const EndpointData&) override {}
  void on_unmatched(const Guid&) override {}
  void on_incompatible_qos(const Guid&, const QosMismatch&) override {}
  void on_inconsistent_topic(const EndpointData&) override {}
  void on_alive(const Guid& writer) override { alive.push_back(writer); }
  std::vector<Guid> alive;
};

constexpr Guid kWriter{{{1}}, {{0, 0, 1, 2}}}, kOther{{{1}}, {{0, 0, 2, 2}}};

TEST(LivelinessSignal, Assertion_CallsThoseThatWaitOnce) {
  LivelinessSignal signal(1s);
  Waiting reader;
  signal.notify(reader, kWriter);
  signal.notify(reader, kWriter);
  signal.assert_at(2s);
  EXPECT_EQ(signal.latest(), 2s);
  EXPECT_THAT(reader.alive, ElementsAre(kWriter));
  signal.assert_at(3s);
  EXPECT_THAT(reader.alive, ElementsAre(kWriter)) << "it does not wait any more";
}

TEST(LivelinessSignal, ReaderThatForgets_IsNotCalled) {
  LivelinessSignal signal(1s);
  Waiting reader;
  signal.notify(reader, kWriter);
  signal.notify(reader, kOther);
  signal.forget(reader, kWriter);
  signal.assert_at(2s);
  EXPECT_THAT(reader.alive, ElementsAre(kOther));
}

TEST(LivelinessSignal, SignalWithoutAnAssertion_CallsNoReader) {
  LivelinessSignal signal(1s);
  Waiting reader;
  signal.notify(reader, kWriter);
  EXPECT_EQ(signal.latest(), 1s);
  EXPECT_THAT(reader.alive, IsEmpty());
}

}  // namespace
}  // namespace ddssec::rtps
