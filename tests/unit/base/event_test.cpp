#include "base/event.hpp"

#include <algorithm>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace ddssec {
namespace {

using namespace std::chrono_literals;

Event event(std::string found, std::string subject = "CN=a") {
  return Event(Error(Code::malformed, {.found = std::move(found)}), std::move(subject), "01.02");
}

TEST(Event, OnlyAnAuthenticatedPeer_IsCalledByItsName) {
  auto of_bob = event("x", "CN=bob");
  EXPECT_TRUE(of_bob.to_line().starts_with("warning: peer claims to be \"CN=bob\" guid 01.02 "))
      << of_bob.to_line();
  EXPECT_EQ(nlohmann::json::parse(of_bob.to_json(0s))["peer_authenticated"], false);
  of_bob.proof = PeerProof::authenticated;
  EXPECT_TRUE(of_bob.to_line().starts_with("warning: peer \"CN=bob\" guid 01.02 "))
      << of_bob.to_line();
  EXPECT_EQ(nlohmann::json::parse(of_bob.to_json(0s))["peer_authenticated"], true);
}

// To have such text in the line, a stranger only needs a certificate with a subject that it chose.
TEST(Event, WhatLooksLikeACode_InAStrangersText_IsNoCodeInTheLine) {
  const auto line = [](const std::string& text) {
    return Event(
               Error(Code::malformed,
                     {.field = text, .expected = text, .found = text, .note = text, .hint = text}),
               text, "01.02")
        .to_line();
  };
  for (const std::string text :
       {"good [plugins_in_use 1620]", "good [[plugins_in_use 1620]", "[plugins_in_use\u00a01620]",
        "[plugins_in_use 1620", "]] [x 1]"}) {
    const auto shown = line(text);
    EXPECT_EQ(shown.find("[plugins_in_use 1620]"), shown.npos) << shown;
    EXPECT_EQ(shown.find("[plugins_in_use\u00a01620]"), shown.npos) << shown;
    EXPECT_EQ(shown.find("[x 1]"), shown.npos) << shown;
    EXPECT_TRUE(shown.ends_with(" [malformed 1003]")) << shown;
  }
  EXPECT_NE(line("good [plugins_in_use 1620]").find("good \\x5bplugins_in_use 1620]"),
            std::string::npos);
  EXPECT_NE(line("partition [0-9] and [a b]").find("partition [0-9] and [a b]"), std::string::npos)
      << "other brackets stay";
}

TEST(Event, PeersName_NeitherEndsItsQuotationNorFillsTheLog) {
  const auto line = event("x", "CN=a\" guid 09.09 \"").to_line();
  EXPECT_EQ(std::ranges::count(line, '"'), 2) << line;
  EXPECT_LT(event("x", std::string(60'000, 'a')).to_line().size(), 600u);
}

// Control characters of C0 and C1, DEL and a bidirectional override could appear in a log as
// separate lines, as colours, or as another text than was sent.
TEST(Event, WhatAPeerSent_IsNoLineOfOursAndNoControlSequence) {
  const std::string evil =
      "x\n0.1 [0] recv: operator logged in\r\x1b[31m\x7f\t\u009b31m\u202e\u2066";
  const Event of_evil(Error(Code::malformed, {evil, 0, evil, evil, evil, evil}), evil, evil);
  for (const auto& line : {of_evil.to_line(), of_evil.to_json(0s), of_evil.error.to_sentence()}) {
    EXPECT_TRUE(std::ranges::none_of(line, [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
        << line;
    for (const char* misleading : {"\u009b", "\u202e", "\u2066"})
      EXPECT_EQ(line.find(misleading), line.npos) << line;
    EXPECT_NE(line.find("operator logged in"), line.npos) << line;
  }
}

TEST(Event, LongTextsOfStrangers_AreCut) {
  const auto line = event(std::string(100'000, 'x')).to_json(0s);
  EXPECT_LT(line.size(), 10'000u);
  EXPECT_TRUE(nlohmann::json::accept(line));
}

TEST(Event, Json_HasEveryFieldAndSurvivesOctetsThatAreNotUtf8) {
  const auto json = nlohmann::json::parse(event("\xff\xfe").to_json(1'764'277'199'007ms));
  EXPECT_EQ(json["time"], "2025-11-27T20:59:59.007Z");
  for (const char* key : {"code", "name", "severity", "peer_subject", "peer_authenticated", "guid",
                          "document", "line", "field", "expected", "found", "hint", "sentence"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_EQ(json["peer_subject"], "CN=a");
  EXPECT_EQ(json["code"], 1003);
}

}  // namespace
}  // namespace ddssec
