#include "base/rate_limited_sink.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "tests/support/recorded_events.hpp"

namespace ddssec {
namespace {

using namespace std::chrono_literals;

const WallTime kStart{std::chrono::seconds(1'700'000'000)};

Event event(std::string found, std::string subject = "CN=a") {
  return Event(Error(Code::malformed, {.found = std::move(found)}), std::move(subject), "01.02");
}

Event of_peer(int number, PeerProof proof) {
  const auto name = std::to_string(number);
  return Event(Error(Code::malformed), "CN=" + name, "01." + name, proof);
}

TEST(RateLimitedSink, SameEvent_PassesOncePerInterval) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock, std::chrono::seconds(10));
  for (int i = 0; i < 5; ++i) sink.raise(event("x"));
  sink.raise(Event(Error(Code::usage), "CN=a", "01.02"));
  sink.raise(Event(Error(Code::malformed), "CN=a", "01.03"));
  EXPECT_EQ(recorder.all.size(), 3u);
  clock.advance(std::chrono::seconds(10));
  sink.raise(event("x"));
  EXPECT_EQ(recorder.all.size(), 4u);
}

// Programs do not print a returned event. The caller may report the same error in an event of its
// own.
TEST(RateLimitedSink, ANextSinkThatThrows_LosesTheEventAndNothingElse) {
  struct Throwing final : EventSink {
    void raise(const Event&) override {
      if (++calls <= 2) throw std::bad_alloc();
    }
    int calls = 0;
  } next;
  ManualClock clock(kStart);
  RateLimitedSink sink(next, clock, 10s);
  const auto raise_some = [&] {
    for (int i = 0; i < 5; ++i) sink.raise(event("x"));
    return next.calls;
  };
  EXPECT_EQ(raise_some(), 1);
  clock.advance(1s);
  EXPECT_EQ(raise_some(), 2) << "the first one was lost";
  clock.advance(1s);
  EXPECT_EQ(raise_some(), 3) << "the second one was lost, too";
  clock.advance(9s);
  EXPECT_EQ(raise_some(), 3) << "the third one was passed on";
  clock.advance(1s);
  EXPECT_EQ(raise_some(), 4);
}

// Otherwise an attacker causes an exception with each message while a log is full.
TEST(RateLimitedSink, ANextSinkThatAlwaysThrows_IsCalledOncePerSecond) {
  struct Throwing final : EventSink {
    void raise(const Event&) override {
      ++calls;
      throw std::bad_alloc();
    }
    int calls = 0;
  } next;
  ManualClock clock(kStart);
  RateLimitedSink sink(next, clock, 10s);
  for (int i = 0; i < 1000; ++i, clock.advance(10ms)) sink.raise(event("x"));
  EXPECT_EQ(next.calls, 10);
}

TEST(RateLimitedSink, AReturnedEvent_DoesNotSuppressTheSameOneThatIsNot) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock, std::chrono::seconds(10));
  for (int i = 0; i < 2; ++i) sink.raise(Event::of_returned(Error(Code::malformed)));
  sink.raise(Event(Error(Code::malformed), {}, {}, PeerProof::not_a_peer));
  ASSERT_EQ(recorder.all.size(), 2u);
  EXPECT_FALSE(recorder.all[1].is_returned);
}

// One peer and one reason make one line, even if its messages and names differ.
TEST(RateLimitedSink, TextChosenByUnprovenPeer_DoesNotPassTheLimitAgain) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (int i = 0; i < 100; ++i) {
    const auto text = std::to_string(i);
    sink.raise(event(text));
    sink.raise(event("x", "CN=" + text));
    sink.raise(Event(Error(Code::malformed, {.field = text, .expected = text, .note = text}),
                     "CN=a", "01.02"));
  }
  EXPECT_EQ(recorder.all.size(), 1u);
}

TEST(RateLimitedSink, ValueFoundInAMessage_DoesNotPassTheLimitAgainAndAnotherDocumentDoes) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (int i = 0; i < 100; ++i) {
    sink.raise(Event(Error(Code::malformed, {.expected = "b", .found = std::to_string(i)})));
    sink.raise(Event(Error(Code::malformed, {.found = std::to_string(i)}), "CN=a", "01.02",
                     PeerProof::authenticated));
  }
  EXPECT_EQ(recorder.all.size(), 2u);
  sink.raise(Event(Error(Code::malformed, {.expected = "c"})));
  sink.raise(Event(Error(Code::malformed, {.document = "crl.pem"})));
  EXPECT_EQ(recorder.all.size(), 4u);
}

TEST(RateLimitedSink, NoticeAboutThisParticipant_PassesOnceForEachValue) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (const char* value : {"1", "2", "2"})
    sink.raise(Event(Error(Code::psk_passphrases_changed, {.found = value}), {}, {},
                     PeerProof::not_a_peer));
  EXPECT_EQ(recorder.all.size(), 2u);
}

TEST(RateLimitedSink, InventedPeers_CrowdOutNeitherUsNorAuthenticatedPeers) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (int i = 0; i < 5'000; ++i) sink.raise(of_peer(i, PeerProof::claimed));
  EXPECT_LE(recorder.all.size(), RateLimitedSink::kMaxClaimed + 1);
  recorder.all.clear();
  for (int i = 0; i < 10; ++i) {
    sink.raise(of_peer(i, PeerProof::authenticated));
    sink.raise(of_peer(100 + i, PeerProof::not_a_peer));
    sink.raise(Event(Error(Code::malformed, {.document = std::to_string(i)})));
  }
  EXPECT_EQ(recorder.all.size(), 30u);
}

Event on_topic(Code code, int topic, std::string subject) {
  return Event(Error(code, {.expected = std::to_string(topic)}), std::move(subject), "01.02",
               PeerProof::authenticated);
}

// Such a peer chooses its topics and partitions, and events repeat them as the expected value.
TEST(RateLimitedSink, AuthenticatedPeer_CrowdsOutNeitherOthersNorItsOtherOffences) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (int i = 0; i < 5'000; ++i) sink.raise(on_topic(Code::malformed, i, "CN=mallory"));
  EXPECT_EQ(recorder.all.size(), RateLimitedSink::kMaxOfAPeer + 1);
  recorder.all.clear();
  sink.raise(on_topic(Code::usage, 1, "CN=mallory"));
  sink.raise(on_topic(Code::malformed, 1, "CN=eve"));
  EXPECT_EQ(recorder.all.size(), 2u);
}

// This holds even if very many certificates work together.
TEST(RateLimitedSink, CrowdOfAuthenticatedPeers_HidesNoCode) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (int i = 0; i < 5'000; ++i) sink.raise(of_peer(i, PeerProof::authenticated));
  recorder.all.clear();
  for (int i = 0; i < 3; ++i) sink.raise(on_topic(Code::usage, i, "CN=eve"));
  ASSERT_EQ(recorder.all.size(), 1u);
  EXPECT_EQ(recorder.all[0].error.code(), Code::usage);
}

// Some events name a peer by its GUID alone.
TEST(RateLimitedSink, ParticipantsOfOneCertificate_HaveOneShare) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  const auto of_guid = [](std::string guid) {
    return Event(Error(Code::malformed), "", std::move(guid), PeerProof::authenticated);
  };
  for (int i = 1000; i < 6'000; ++i) sink.raise(of_guid("8123456789ab" + std::to_string(i)));
  EXPECT_LE(recorder.all.size(), RateLimitedSink::kMaxOfAPeer + 1);
  recorder.all.clear();
  for (int i = 0; i < 3; ++i) sink.raise(of_guid("8123456789a" + std::to_string(i) + "0001"));
  EXPECT_EQ(recorder.all.size(), 3u);
}

TEST(RateLimitedSink, AFloodOfDifferentEvents_IsBounded) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (int i = 0; i < 5'000; ++i) sink.raise(of_peer(i, PeerProof::authenticated));
  EXPECT_GE(recorder.all.size(), RateLimitedSink::kMaxRemembered);
  EXPECT_LE(recorder.all.size(), RateLimitedSink::kMaxRemembered + 1);
}

TEST(RateLimitedSink, ANewEvent_PassesAgainAfterAFlood) {
  test::RecordedEvents recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (const auto proof : {PeerProof::claimed, PeerProof::authenticated}) {
    for (int i = 0; i < 5'000; ++i) sink.raise(of_peer(i, proof));
    clock.advance(std::chrono::seconds(11));
    recorder.all.clear();
    sink.raise(of_peer(-1, proof));
    EXPECT_EQ(recorder.all.size(), 1u);
  }
}

}  // namespace
}  // namespace ddssec
