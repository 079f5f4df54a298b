#include "plugins/cryptography/reclaim.hpp"

#include <future>
#include <thread>

#include <gtest/gtest.h>

namespace ddssec::cryptography {
namespace {

std::promise<void> guarded;
std::promise<void> checked;

// Reads shared objects after everything else of the thread is destroyed, as a function that exit()
// calls may do.
struct LateReader {
  ~LateReader() {
    const ReadGuard guard;
    guarded.set_value();
    checked.get_future().wait();
  }
};

TEST(Reclaim, ReaderAfterItsThreadsLeaseEnded_OtherThreadReads_ObjectStays) {
  std::thread late([] {
    // It is constructed before the lease, so it is destroyed after it.
    static thread_local const LateReader reader;
    static_cast<void>(&reader);
    const ReadGuard guard;
  });
  guarded.get_future().wait();
  std::thread([] { const ReadGuard guard; }).join();
  EXPECT_FALSE(is_safe(retirement_epoch()));
  checked.set_value();
  late.join();
  EXPECT_TRUE(is_safe(retirement_epoch()));
}

}  // namespace
}  // namespace ddssec::cryptography
