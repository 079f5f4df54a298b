#include "base/event.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ddssec {
namespace {

struct Recorder : EventSink {
  void raise(const Event& event) override { events.push_back(event); }
  std::vector<Event> events;
};

const WallTime kStart{std::chrono::seconds(1'700'000'000)};

Event event(std::string found, std::string subject = "CN=a") {
  return Event(Error(Code::malformed, {.found = std::move(found)}), std::move(subject), "01.02");
}

TEST(RateLimitedSink, LetsTheSameEventThroughOncePerInterval) {
  Recorder recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock, std::chrono::seconds(10));
  for (int i = 0; i < 5; ++i) sink.raise(event("x"));
  sink.raise(event("y"));
  EXPECT_EQ(recorder.events.size(), 2u);
  clock.advance(std::chrono::seconds(10));
  sink.raise(event("x"));
  EXPECT_EQ(recorder.events.size(), 3u);
}

TEST(RateLimitedSink, AFloodOfDifferentEventsIsBounded) {
  Recorder recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (int i = 0; i < 100'000; ++i) sink.raise(event(std::to_string(i)));
  EXPECT_LE(recorder.events.size(), RateLimitedSink::kMostRemembered + 1);
}

TEST(RateLimitedSink, ANewEventPassesAgainAfterAFlood) {
  Recorder recorder;
  ManualClock clock(kStart);
  RateLimitedSink sink(recorder, clock);
  for (int i = 0; i < 5'000; ++i) sink.raise(event(std::to_string(i)));
  clock.advance(std::chrono::seconds(11));
  recorder.events.clear();
  sink.raise(event("fresh"));
  EXPECT_EQ(recorder.events.size(), 1u);
}

TEST(Event, JsonHasEveryFieldAndSurvivesOctetsThatAreNotUtf8) {
  const auto json = nlohmann::json::parse(event("\xff\xfe").to_json());
  for (const char* key : {"code", "name", "severity", "peer_subject", "guid", "document", "line",
                          "field", "expected", "found", "hint", "sentence"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["peer_subject"], "CN=a");
  EXPECT_EQ(json["code"], 1003);
}

}  // namespace
}  // namespace ddssec
