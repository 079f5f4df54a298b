// How often a reader that is said to have ended is asked.
#include "rtps/participant/doubted_readers.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

TEST(DoubtedReader, SilentReader_IsAskedLessAndLess) {
  struct Count final : DoubtedReaders::Host {
    std::optional<std::uint64_t> answers(const DoubtedReaders::Pair&) override { return 7; }
    void ask(const DoubtedReaders::Pair&) override { ++asked; }
    void on_silent(const DoubtedReaders::Pair&) override { ++silent; }
    int asked = 0, silent = 0;
  } host;
  DoubtedReaders doubted(host);
  for (int i = 0; i < 3600; ++i) {
    doubted.add({}, seconds(i));
    doubted.tick(seconds(i));
  }
  EXPECT_EQ(host.silent, 1);
  EXPECT_LE(host.asked, 4 + 5 + 3600 / 32);
  EXPECT_GE(host.asked, 3500 / 32);
}

}  // namespace
}  // namespace ddssec::rtps
