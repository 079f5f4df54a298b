// What the agent keeps of an event that another user's process sent.
#include "cli/agent/agent_events.hpp"

#include <gtest/gtest.h>

namespace ddssec::cli {
namespace {

Json event_with(const std::string& mode, const std::string& sha256) {
  const Json file = {{"path", "a"}, {"mode", mode}, {"sha256", sha256}};
  return {{"event", "renewed"}, {"unknown", 1}, {"files", Json::array({file})}};
}

TEST(KnownMembers, ModeAndHash_AreKeptIfTheyAreDigits) {
  const std::string hash(64, 'c');
  const auto out = known_members(event_with("0644", hash));
  EXPECT_EQ(out["files"][0], (Json{{"path", "a"}, {"mode", "0644"}, {"sha256", hash}}));
  EXPECT_FALSE(out.contains("unknown"));
}

// `agent --once --verbose` prints them as they are.
TEST(KnownMembers, ModeAndHash_ThatCouldControlATerminal_AreZeros) {
  const std::string escape = "\033]0;x\007", zeros(64, '0');
  for (const auto& mode : {escape, std::string("0644\n"), std::string("0998"), std::string()})
    for (const auto& hash : {escape, std::string(63, 'c') + '\n', std::string(65, 'c')})
      EXPECT_EQ(known_members(event_with(mode, hash))["files"][0],
                (Json{{"path", "a"}, {"mode", "0000"}, {"sha256", zeros}}));
}

}  // namespace
}  // namespace ddssec::cli
