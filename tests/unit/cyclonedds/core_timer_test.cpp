#include "plugins/cyclonedds/core_timer.hpp"

#include <limits>
#include <memory>
#include <sys/mman.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "plugins/cyclonedds/core_handshake.hpp"

namespace ddssec::cyclonedds {
namespace {

constexpr DDS_Security_GUID_t kRemote = {{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12},
                                         {{0, 1, 2}, 0xc1}};

struct Stopped {
  void* machine = nullptr;
  std::int64_t timeout = 0;
  int times = 0;
} stopped;

void set_timeout(void* machine, void*, std::int64_t timeout) {
  stopped = {machine, timeout, stopped.times + 1};
}

struct CoreTimerTest : testing::Test {
  void SetUp() override {
    stopped = {};
    plugin.gv = reinterpret_cast<ddsi_domaingv*>(&domain);
    handshake->plugin = &plugin;
    handshake->domain = &domain;
    handshake->machine = &machine;
    handshake->remote = {0x01020304, 0x05060708, 0x090a0b0c, 0x000102c1};
    machine.argument = handshake.get();
  }

  bool stop() const {
    return CoreTimer(set_timeout).stop({&plugin, &handshake->local_auth_request, &kRemote});
  }

  int domain = 0;
  dds_security_authentication plugin{};
  CoreStateMachine machine{};
  std::unique_ptr<CoreHandshake> handshake = std::make_unique<CoreHandshake>();
};

TEST_F(CoreTimerTest, HandshakeOfTheCall_ItsTimerIsStopped) {
  EXPECT_TRUE(stop());
  EXPECT_EQ(stopped.machine, &machine);
  EXPECT_EQ(stopped.timeout, std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(stopped.times, 1);
}

TEST_F(CoreTimerTest, OtherLayout_NothingIsCalled) {
  const CoreHandshake good = *handshake;
  const auto refuses = [&](auto change) {
    change();
    EXPECT_FALSE(stop());
    *handshake = good;
    machine.argument = handshake.get();
  };
  refuses([&] { handshake->plugin = &domain; });
  refuses([&] { handshake->domain = &plugin; });
  refuses([&] { handshake->remote[0] ^= 1; });
  refuses([&] { handshake->remote[3] ^= 1; });
  refuses([&] { handshake->machine = nullptr; });
  refuses([&] { machine.argument = &domain; });
  EXPECT_EQ(stopped.times, 0);
  EXPECT_TRUE(stop());
}

// Another core may pass the address of an object that has nothing before it in memory.
TEST_F(CoreTimerTest, NothingBeforeTheArgument_NothingIsReadOrCalled) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  void* const pages =
      ::mmap(nullptr, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(pages, MAP_FAILED);
  EXPECT_EQ(::mprotect(pages, page, PROT_NONE), 0);
  const auto* const argument =
      reinterpret_cast<const DDS_Security_DataHolder*>(static_cast<const std::byte*>(pages) + page);
  EXPECT_FALSE(CoreTimer(set_timeout).stop({&plugin, argument, &kRemote}));
  EXPECT_EQ(stopped.times, 0);
  ::munmap(pages, 2 * page);
}

TEST_F(CoreTimerTest, MachineThatCannotBeRead_NothingIsCalled) {
  handshake->machine = reinterpret_cast<CoreStateMachine*>(8);
  EXPECT_FALSE(stop());
  EXPECT_EQ(stopped.times, 0);
}

TEST_F(CoreTimerTest, HostWithoutTheFunction_NothingIsRead) {
  EXPECT_FALSE(CoreTimer(nullptr).stop({nullptr, nullptr, nullptr}));
  // This program is not Cyclone DDS.
  EXPECT_FALSE(CoreTimer::of_host(nullptr).stop({nullptr, nullptr, nullptr}));
}

}  // namespace
}  // namespace ddssec::cyclonedds
