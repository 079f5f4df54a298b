// Replies to handshake requests, most of which are forged: how many are kept, and how much they
// take.
#include "rtps/security/handshake_answers.hpp"

#include <gtest/gtest.h>

#include "plugins/authentication/authentication.hpp"
#include "tests/support/seeded_random.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace std::chrono_literals;

class HandshakeAnswersTest : public ::testing::Test {
 protected:
  HandshakeAnswer answer(std::int64_t number, MonotonicTime since = 0s, std::size_t octets = 1000) {
    HandshakeAnswer out{{number}, {},    {},    Bytes(32, static_cast<std::uint8_t>(number)),
                        {},       since, octets};
    out.request[0] = static_cast<std::uint8_t>(number);
    out.reply.data.emplace_back();
    return out;
  }
  std::vector<std::int64_t> kept() const {
    std::vector<std::int64_t> out;
    for (const auto& one : answers_.all()) out.push_back(one.handle.value);
    return out;
  }

 private:
  ManualClock clock_{pki::kNow};
  SeededRandom random_{1};
  test::RecordedEvents events_;
  std::unique_ptr<spi::Authentication> plugin_ =
      authentication::make_authentication({clock_, random_, events_});

 protected:
  std::size_t account_ = 0;
  HandshakeAnswers answers_{*plugin_, account_};
};

TEST_F(HandshakeAnswersTest, Octets_AreCountedForAllPeers) {
  constexpr auto kEach = 1000 + HandshakeAnswers::kPrice;
  answers_.add(answer(1));
  answers_.add(answer(2));
  EXPECT_EQ(answers_.octets(), 2 * kEach);
  EXPECT_EQ(account_, 2 * kEach);
  answers_.evict_largest();
  EXPECT_EQ(kept(), std::vector<std::int64_t>{2});
  EXPECT_EQ(account_, kEach);
  answers_.expire(HandshakeAnswers::kLife);
  EXPECT_TRUE(answers_.empty());
  answers_.evict_largest();
  EXPECT_EQ(account_, 0u);
}

TEST_F(HandshakeAnswersTest, Death_GivesTheOctetsBack) {
  std::size_t account = 0;
  {
    ManualClock clock{pki::kNow};
    SeededRandom random{1};
    test::RecordedEvents events;
    const auto plugin = authentication::make_authentication({clock, random, events});
    HandshakeAnswers others(*plugin, account);
    others.add(answer(1));
    EXPECT_GT(account, 0u);
  }
  EXPECT_EQ(account, 0u);
}

TEST_F(HandshakeAnswersTest, Finish_EndsAllOthers) {
  for (const std::int64_t number : {1, 2, 3}) answers_.add(answer(number));
  answers_.finish({2});
  EXPECT_TRUE(answers_.empty());
  EXPECT_EQ(account_, 0u);
}

TEST_F(HandshakeAnswersTest, ManyRequests_PushOutTheOldestThatIsOldEnough) {
  const auto most = static_cast<std::int64_t>(HandshakeAnswers::kMax);
  for (std::int64_t number = 1; number <= most; ++number) answers_.add(answer(number));
  const Bytes challenge(32, 0xff);
  EXPECT_FALSE(answers_.make_room(challenge, HandshakeAnswers::kMinAge - 1ms));
  EXPECT_TRUE(answers_.make_room(challenge, HandshakeAnswers::kMinAge));
  EXPECT_EQ(kept().size(), HandshakeAnswers::kMax - 1);
  EXPECT_EQ(kept().front(), 2);
}

TEST_F(HandshakeAnswersTest, RequestsOfOneChallenge_PushOutEachOther) {
  answers_.add(answer(9));
  for (std::size_t i = 0; i < HandshakeAnswers::kMaxPerChallenge; ++i) answers_.add(answer(1));
  EXPECT_TRUE(answers_.make_room(answer(1).challenge, 1s));
  EXPECT_EQ(kept().size(), HandshakeAnswers::kMaxPerChallenge);
  EXPECT_EQ(kept().front(), 9);
}

TEST_F(HandshakeAnswersTest, Repetitions_TakeTurns) {
  for (std::int64_t number = 1; number <= 6; ++number) {
    auto one = answer(number);
    one.reply.identity.sequence_number = number;
    answers_.add(std::move(one));
  }
  std::vector<GenericMessage> out;
  answers_.repeat(out);
  answers_.repeat(out);
  std::vector<std::int64_t> numbers;
  for (const auto& message : out) numbers.push_back(message.identity.sequence_number);
  EXPECT_EQ(numbers, (std::vector<std::int64_t>{1, 2, 3, 4, 5, 6, 1, 2}));
}

TEST_F(HandshakeAnswersTest, Request_IsFoundByDigestAndHandle) {
  answers_.add(answer(7));
  EXPECT_EQ(answers_.to(answer(7).request)->handle.value, 7);
  EXPECT_EQ(answers_.to(answer(8).request), nullptr);
  EXPECT_EQ(answers_.with({7})->handle.value, 7);
  EXPECT_EQ(answers_.with({8}), nullptr);
}

}  // namespace
}  // namespace ddssec::rtps
