// The property org.ddssec.busy_wait of secured participants.
#include <ctime>

#include "tests/unit/rtps_security/secured_dcps.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

struct BusyWaitProperty : ::testing::Test {
  DomainParticipantOptions options(const std::string& value) {
    auto out = process.options("CN=alice,O=Example", {});
    if (!value.empty())
      out.security->properties.push_back({std::string(spi::property::kBusyWait), value, false});
    return out;
  }
  // The time for which the processor works while the participant waits for 100 ms.
  std::chrono::nanoseconds cost_of(const DomainParticipantOptions& wanted) {
    const auto made = DomainParticipant::create(wanted, process.services);
    EXPECT_TRUE(made) << made.error().to_sentence();
    for (int i = 0; i < 10; ++i) (*made)->poll(0ms);
    const auto before = processor_time();
    for (int i = 0; i < 100; ++i) (*made)->poll(1ms);
    return processor_time() - before;
  }
  static std::chrono::nanoseconds processor_time() {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
  }
  ManualClock clock{pki::kNow};
  SecuredProcess process{clock};
};

TEST_F(BusyWaitProperty, NumberOutOfRange_ParticipantIsRefused) {
  const auto refused = DomainParticipant::create(options("1001"), process.services);
  ASSERT_EQ(code_of(refused), Code::invalid_property);
  EXPECT_EQ(refused.error().details().document, spi::property::kBusyWait);
}

TEST_F(BusyWaitProperty, Value_TakesPrecedenceOverTheOption) {
  auto sleeping = options("0");
  sleeping.busy_wait = 1ms;
  const auto busy = cost_of(options("1000"));
  EXPECT_GT(busy, 2 * cost_of(options("")));
  EXPECT_GT(busy, 2 * cost_of(sleeping));
}

}  // namespace
}  // namespace ddssec::rtps
