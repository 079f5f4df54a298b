// The sockets of a participant, and what an entity contains.
#include "rtps/transport/participant_sockets.hpp"

#include <cstdlib>

#include <gmock/gmock.h>

#include "rtps/dcps/contained_entities.hpp"
#include "rtps/transport/interface_watch.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using namespace std::chrono_literals;

constexpr std::size_t kBuffer = 65536;

struct ParticipantSocketsTest : ::testing::Test {
  const DomainId domain = static_cast<DomainId>(::getpid() % 200 + 30);
  std::unique_ptr<ParticipantSockets> open() const {
    const std::vector<std::string> loopback{"127.0.0.1"};
    return *ParticipantSockets::open(domain, *choose_interfaces(loopback),
                                     {.receive_buffer = kBuffer});
  }
};

TEST_F(ParticipantSocketsTest, Open_TakenIndexes_AreSkipped) {
  const auto first = open(), second = open();
  EXPECT_LT(first->index(), second->index());
  for (const auto* sockets : {first.get(), second.get()}) {
    ASSERT_EQ(sockets->metatraffic().size(), 1u);
    EXPECT_EQ(sockets->metatraffic().front().port, ports::metatraffic(domain, sockets->index()));
    EXPECT_EQ(sockets->user().front().port, ports::user(domain, sockets->index()));
  }
}

TEST_F(ParticipantSocketsTest, Send_ReachesTheSocketThatListens) {
  const auto from = open(), to = open();
  std::vector<Bytes> received;
  ASSERT_TRUE(to->listen([&](UdpSocket& socket) {
    for (std::size_t i = 0, count = socket.fetch(); i < count; ++i)
      received.push_back(to_bytes(socket.datagram(i)));
  }));
  const Bytes message{1, 2, 3};
  from->send(message, to->user());
  from->send(message, to->metatraffic());
  for (int i = 0; i < 100 && received.size() < 2; ++i) to->loop().wait(10ms);
  EXPECT_THAT(received, ::testing::ElementsAre(message, message));
}

TEST_F(ParticipantSocketsTest, StaysHere_LoopbackAndOwnAddresses) {
  const auto sockets = open();
  EXPECT_TRUE(sockets->stays_here(*Locator::parse("127.0.0.1", 7400)));
  EXPECT_FALSE(sockets->stays_here(*Locator::parse("192.0.2.1", 7400)));
  EXPECT_FALSE(sockets->has_joined());
}

// The kernel keeps datagrams to an address without a machine, and counts them for the socket.
TEST_F(ParticipantSocketsTest, Send_ManyAddressesWithoutAMachine_OthersGetTheirs) {
  if (std::system("ip link add dead0 type veth peer name dead1 2>/dev/null && "
                  "ip addr add 10.77.0.1/24 dev dead0 && ip link set dead0 up && "
                  "ip link set dead1 up") != 0)
    GTEST_SKIP() << "SKIPPED: this system makes no network interfaces for a test";
  const std::vector<std::string> ethernet{"10.77.0.1"};
  const auto from =
      *ParticipantSockets::open(domain, *choose_interfaces(ethernet), {.receive_buffer = kBuffer});
  LocatorList dead;
  for (int i = 100; i < 140; ++i)
    dead.push_back(*Locator::parse("10.77.0." + std::to_string(i), 7411));
  auto to = UdpSocket::bind(*Locator::parse("127.0.0.1", 0));
  ASSERT_TRUE(to);
  const std::vector<Locator> alive{to->local()};
  std::size_t received = 0;
  for (int round = 0; round < 50; ++round) {
    from->send(Bytes(30'000), dead);
    from->send(Bytes{1, 2, 3}, alive);
    received += to->fetch();
  }
  EXPECT_EQ(received, 50u);  // not only the first few
  EXPECT_EQ(std::system("ip link del dead0"), 0);
}

// The address changes as it does with DHCP or when a cable is plugged in.
TEST_F(ParticipantSocketsTest, Use_AnotherAddress_JoinsTheGroupThere) {
  const auto run = [](const std::string& command) { return std::system(command.c_str()) == 0; };
  if (!run("ip link add here0 type veth peer name there0 2>/dev/null && ip link set there0 up"))
    GTEST_SKIP() << "SKIPPED: this system makes no network interfaces for a test";
  const auto watch = InterfaceWatch::open();
  ASSERT_TRUE(watch);
  watch->drain();
  const auto sockets = *ParticipantSockets::open(
      domain, *choose_interfaces({}), {.receive_buffer = kBuffer, .interfaces_may_change = true});
  const auto group = *Locator::parse("239.255.0.1", ports::base(domain));
  ASSERT_TRUE(sockets->join(group, sockets->interfaces().front()));
  int received = 0;
  ASSERT_TRUE(sockets->listen([&](UdpSocket& socket) { received += int(socket.fetch()); }));
  const auto hears_the_group = [&] {
    received = 0;
    sockets->send(Bytes{1}, std::vector<Locator>{group});  // multicast returns to its sender
    sockets->loop().wait(100ms);
    return received == 1;
  };
  EXPECT_FALSE(watch->drain());
  for (const std::string address : {"10.78.0.1", "10.78.0.2", "10.78.0.3"}) {
    ASSERT_TRUE(run("ip addr flush dev here0; ip addr add " + address +
                    "/24 dev here0; ip link set here0 up"));
    EXPECT_TRUE(watch->drain());
    auto chosen = *choose_interfaces({});
    ASSERT_EQ(to_string(chosen), "here0 (" + address + ")");
    EXPECT_TRUE(sockets->use(std::move(chosen)).empty());
    ASSERT_EQ(sockets->metatraffic().size(), 1u);
    EXPECT_EQ(sockets->metatraffic().front().address, Locator::parse(address, 0)->address);
    EXPECT_TRUE(hears_the_group()) << address;
  }
  // The interface is replaced by another device with the same name and address, such as a USB
  // adapter that is plugged in again.
  ASSERT_TRUE(
      run("ip link del here0 && ip link add here0 type veth peer name there0 && "
          "ip link set there0 up && ip addr add 10.78.0.3/24 dev here0 && "
          "ip link set here0 up"));
  EXPECT_TRUE(watch->drain());
  EXPECT_TRUE(sockets->use(*choose_interfaces({})).empty());
  EXPECT_TRUE(hears_the_group());
  ASSERT_TRUE(run("ip link del here0"));
  EXPECT_TRUE(watch->drain());
  EXPECT_TRUE(sockets->use(*choose_interfaces({})).empty());
  EXPECT_EQ(to_string(sockets->interfaces()), "lo (127.0.0.1)");
}

// One socket cannot join more than 20 groups at once.
TEST_F(ParticipantSocketsTest, Use_InterfacesThatComeAndGo_LeaveNothingBehind) {
  const auto run = [](const std::string& command) { return std::system(command.c_str()) == 0; };
  const auto sockets = *ParticipantSockets::open(
      domain, *choose_interfaces({}), {.receive_buffer = kBuffer, .interfaces_may_change = true});
  ASSERT_TRUE(sockets->join(*Locator::parse("239.255.0.1", ports::base(domain)),
                            sockets->interfaces().front()));
  for (int i = 0; i < 30; ++i) {
    if (!run("ip link add here0 type veth peer name there0 2>/dev/null && "
             "ip addr add 10.78.0.1/24 dev here0 && ip link set here0 up"))
      GTEST_SKIP() << "SKIPPED: this system makes no network interfaces for a test";
    EXPECT_TRUE(sockets->use(*choose_interfaces({})).empty()) << i;
    ASSERT_TRUE(run("ip link del here0"));
    EXPECT_TRUE(sockets->use(*choose_interfaces({})).empty()) << i;
  }
}

struct Named final : Entity {
  Named(ParticipantContext& context, std::string called)
      : Entity(context), name_(std::move(called)) {}
  Status enable() override { return {}; }
  const std::string& name() const { return name_; }

 private:
  const std::string name_;
};

struct ContainedEntitiesTest : ::testing::Test, UnservedContext {
  ContainedEntities<Named> entities{context};
  Named& add(std::string name) {
    return *entities.add(std::make_unique<Named>(context, std::move(name)));
  }
};

TEST_F(ContainedEntitiesTest, Named_FindsByName) {
  auto& one = add("one");
  add("two");
  EXPECT_EQ(entities.named("one"), &one);
  EXPECT_EQ(entities.named("three"), nullptr);
}

TEST_F(ContainedEntitiesTest, Remove_RefusesUsedAndUnknownOnes) {
  auto& one = add("one");
  const Named elsewhere(context, "one");
  EXPECT_EQ(code_of(entities.remove(one, false)), Code::rtps_precondition_not_met);
  EXPECT_EQ(code_of(entities.remove(elsewhere, true)), Code::rtps_precondition_not_met);
  EXPECT_EQ(entities.all().size(), 1u);
  EXPECT_TRUE(entities.remove(one, true));
  EXPECT_TRUE(entities.all().empty());
}

TEST_F(ContainedEntitiesTest, Release_LeavesNone) {
  add("one");
  add("two");
  EXPECT_EQ(entities.release().size(), 2u);
  EXPECT_TRUE(entities.all().empty());
}

}  // namespace
}  // namespace ddssec::rtps
