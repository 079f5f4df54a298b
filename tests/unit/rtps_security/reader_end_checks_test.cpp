// How often a reader that is said to have ended is asked.
#include "rtps/participant/reader_end_checks.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST(DoubtedReader, SilentReader_IsAskedLessAndLess) {
  struct Count final : ReaderEndChecks::Host {
    std::optional<std::uint64_t> answers(const ReaderEndChecks::Pair&) override { return 7; }
    void request_sign_of_life(const ReaderEndChecks::Pair&) override { ++asked; }
    void on_no_answer(const ReaderEndChecks::Pair&) override { ++silent; }
    int asked = 0, silent = 0;
  } host;
  ReaderEndChecks checks(host);
  for (int i = 0; i < 3600; ++i) {
    checks.add({}, seconds(i));
    checks.tick(seconds(i));
  }
  EXPECT_EQ(host.silent, 1);
  EXPECT_LE(host.asked, 4 + 5 + 3600 / 32);
  EXPECT_GE(host.asked, 3500 / 32);
}

}  // namespace
}  // namespace ddssec::rtps
