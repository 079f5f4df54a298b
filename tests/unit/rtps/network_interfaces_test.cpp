// Interfaces, selected by name and address, and the addresses of a peer that are used.
#include "rtps/transport/network_interfaces.hpp"

#include <netinet/in.h>

#include <gmock/gmock.h>

#include "rtps/transport/udp_socket.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "tests/unit/rtps/wire_helpers.hpp"

namespace ddssec::rtps {
namespace {

using testing::code_of;

TEST(Interfaces, NameAndAddress_GiveTheSame) {
  const auto by_name = choose_interfaces(std::vector<std::string>{"lo"});
  const auto by_address = choose_interfaces(std::vector<std::string>{"127.0.0.1", "lo"});
  ASSERT_TRUE(by_name && by_address);
  EXPECT_EQ(to_string(*by_name), "lo (127.0.0.1)");
  EXPECT_EQ(to_string(*by_address), "lo (127.0.0.1)");
  EXPECT_EQ(by_name->front().prefix_bits, 8u);
}

// The test's own network has no other interface.
TEST(Interfaces, LoopbackAlone_IsUsed) {
  const auto chosen = choose_interfaces({});
  ASSERT_TRUE(chosen);
  EXPECT_EQ(chosen->front().address.kind, LocatorKind::udp_v4);
  EXPECT_TRUE(UdpSocket::bind(chosen->front().address));
}

TEST(Interfaces, UnknownInterface_IsRefusedWithThoseThatExist) {
  const auto refused = choose_interfaces(std::vector<std::string>{"lo", "nosuch0"});
  ASSERT_EQ(code_of(refused), Code::rtps_address_not_here);
  EXPECT_EQ(refused.error().details().found, "nosuch0");
  const auto& known = refused.error().details().expected;
  EXPECT_THAT(known, ::testing::HasSubstr("lo (127.0.0.1"));
  EXPECT_EQ(known.find("127.0.0.1"), known.rfind("127.0.0.1")) << "each address once: " << known;
  for (const char* no_address : {"0.0.0.0", "::"})
    EXPECT_EQ(code_of(choose_interfaces(std::vector<std::string>{no_address})),
              Code::invalid_property);
  EXPECT_EQ(code_of(choose_interfaces(std::vector<std::string>{"127.0.0.1", "::1"})),
            Code::invalid_property);
}

Locator at(const char* address) { return *Locator::parse(address, 7410); }

struct Ways {
  std::vector<Locator> announced, kept;
};

TEST(Interfaces, PeersAddresses_OnlyTheNearestAreKept) {
  const NetworkInterface own[] = {{"eth0", *Locator::parse("192.0.2.5", 0), 24, true},
                                  {"docker0", *Locator::parse("172.17.0.1", 0), 16, true}};
  const Ways table[] = {
      {{at("192.0.2.5"), at("172.17.0.1")}, {at("192.0.2.5")}},  // this machine
      {{at("172.17.0.1"), at("192.0.2.6")}, {at("192.0.2.6")}},  // the docker0 of another machine
      {{at("10.1.1.1"), at("192.0.2.6")}, {at("192.0.2.6")}},    // a network that only the peer has
      {{at("192.0.2.6"), at("172.17.3.3")}, {at("192.0.2.6"), at("172.17.3.3")}},
      // This machine is behind a router.
      {{at("10.1.1.1"), at("10.2.2.2")}, {at("10.1.1.1"), at("10.2.2.2")}},
      {{at("172.17.0.1")}, {at("172.17.0.1")}},
      {{at("fd00::1"), at("192.0.2.6")}, {at("192.0.2.6")}}};
  for (const auto& [announced, kept] : table) {
    auto locators = announced;
    keep_nearest(locators, own);
    EXPECT_EQ(locators, kept) << to_string(announced.front());
    locators = announced;
    keep_nearest(locators, {});
    EXPECT_EQ(locators, announced);
  }
}

TEST(Interfaces, AnInterfaceWithSeveralAddresses_IsNamedOnce) {
  const auto of = [](const char* name, const char* address) {
    return NetworkInterface{name, *Locator::parse(address, 0), 8, true};
  };
  const std::vector<NetworkInterface> known = {of("lo", "127.0.0.1"), of("eth0", "10.0.0.1"),
                                               of("lo", "::1"), of("", "192.0.2.1")};
  EXPECT_EQ(to_string(known), "lo (127.0.0.1, [::1]), eth0 (10.0.0.1) and 192.0.2.1");
}

}  // namespace
}  // namespace ddssec::rtps
