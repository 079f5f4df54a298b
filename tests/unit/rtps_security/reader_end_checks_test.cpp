// How often a reader is asked whether it has ended, after a report says so.
#include "rtps/participant/reader_end_checks.hpp"

#include <map>

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct Count final : ReaderEndChecks::Host {
  std::optional<std::uint64_t> answers(const ReaderEndChecks::ReaderPair&) override {
    return matches ? std::optional<std::uint64_t>(7) : std::nullopt;
  }
  void request_sign_of_life(const ReaderEndChecks::ReaderPair& pair) override {
    ++asked[pair.reader.prefix.octets[0]];
  }
  void on_no_answer(const ReaderEndChecks::ReaderPair&) override { ++silent; }
  std::map<std::uint8_t, int> asked;
  int silent = 0;
  bool matches = true;
};

ReaderEndChecks::ReaderPair pair_with(std::uint8_t participant, std::uint32_t reader = 0) {
  ReaderEndChecks::ReaderPair pair;
  pair.reader.prefix.octets[0] = participant;
  pair.reader.entity.octets = {static_cast<std::uint8_t>(reader >> 8),
                               static_cast<std::uint8_t>(reader), 0, 7};
  return pair;
}

TEST(DoubtedReader, SilentReader_IsAskedAtMostEachFourSecondsAndAtLeast) {
  Count host;
  ReaderEndChecks checks(host);
  for (int i = 0; i < 3600; ++i) {
    checks.add(pair_with(0), seconds(i));
    checks.tick(seconds(i));
  }
  EXPECT_EQ(host.silent, 1);
  EXPECT_LE(host.asked[0], 4 + 5 + 3600 / 4);
  EXPECT_GE(host.asked[0], 3500 / 4);
}

// If Cyclone DDS reports the ends of readers in this way, they stay silent for ever.
TEST(DoubtedReader, ManySilentReadersOfOneParticipant_ShareTheQuestions) {
  Count host;
  ReaderEndChecks checks(host);
  constexpr int kReaders = 1000, kSeconds = 3600;
  for (std::uint32_t i = 0; i < kReaders; ++i) checks.add(pair_with(1, i), seconds(0));
  checks.add(pair_with(2), seconds(0));
  for (int i = 0; i < kSeconds; ++i) checks.tick(seconds(i));
  EXPECT_LE(host.asked[1], 8 * kReaders + 16 * kSeconds);
  EXPECT_GE(host.asked[2], (kSeconds - 100) / 4) << "another one does not wait for them";
  host.matches = false;
  checks.tick(seconds(2 * kSeconds));
  EXPECT_EQ(checks.next(), kNever);
}

}  // namespace
}  // namespace ddssec::rtps
