// What a participant reports if the machine does not give it what it needs.
#include "rtps/transport/host_sockets.hpp"

#include <csignal>
#include <filesystem>
#include <fstream>

#include "rtps/transport/network_interfaces.hpp"
#include "rtps/transport/ports.hpp"
#include "rtps/transport/udp_socket.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"

namespace ddssec::rtps {
namespace {

using testing::code_of;

struct NetworkTrouble : ::testing::Test {
  SystemClock clock;
  SystemRandom random;
  test::RecordedEvents events;

  auto create(DomainParticipantOptions options) {
    options.own_thread = false;
    return DomainParticipant::create(std::move(options), PluginServices{clock, random, events});
  }
  std::vector<Code> said() const { return events.codes(); }
};

TEST_F(NetworkTrouble, ASmallReceiveBuffer_IsOneWarning) {
  const auto participant =
      create({.domain_id = 74, .interfaces = {"lo"}, .receive_buffer = 64 << 10});
  ASSERT_TRUE(participant);
  for (int i = 0; i < 10; ++i) (*participant)->poll(std::chrono::milliseconds(1));
  EXPECT_THAT(said(), ::testing::ElementsAre(Code::rtps_receive_buffer_small, Code::rtps_joined));
  EXPECT_EQ(events.all[0].severity, Severity::warning);
}

TEST_F(NetworkTrouble, AllPortsTaken_IsSaid) {
  const auto octet = [](int shift) { return std::to_string(::getpid() >> shift & 0xff); };
  const auto address = "127.74." + octet(8) + "." + octet(0);
  std::vector<UdpSocket> taken;
  for (int i = 0; i < ports::kMaxIndexes; ++i)
    taken.push_back(
        *UdpSocket::bind(*Locator::parse(address, static_cast<std::uint16_t>(ports::user(74, i)))));
  const auto refused = create({.domain_id = 74, .interfaces = {address}});
  ASSERT_EQ(code_of(refused), Code::rtps_port_taken);
  EXPECT_THAT(refused.error().to_sentence(), ::testing::HasSubstr("participant index"));
  taken.erase(taken.begin() + 7);
  EXPECT_TRUE(create({.domain_id = 74, .interfaces = {address}}));
}

// Without multicast, others announce themselves to the first ports of a machine only.
TEST_F(NetworkTrouble, AnIndexThatPeersDoNotTry_IsSaid) {
  const auto octet = [](int shift) { return std::to_string(::getpid() >> shift & 0xff); };
  const auto address = "127.75." + octet(8) + "." + octet(0);
  const auto note_at = [&](int index) {
    std::vector<UdpSocket> taken;
    for (int i = 0; i < index; ++i)
      taken.push_back(*UdpSocket::bind(
          *Locator::parse(address, static_cast<std::uint16_t>(ports::user(74, i)))));
    const auto made = create({.domain_id = 74, .interfaces = {address}, .multicast = false});
    EXPECT_TRUE(made && (*made)->index() == index);
    return events.all.back().error.details().note;
  };
  constexpr int kFirst = DomainParticipant::kAnnouncedIndexes;
  EXPECT_THAT(note_at(kFirst - 1), ::testing::Not(::testing::HasSubstr("participant index")));
  EXPECT_THAT(note_at(kFirst), ::testing::HasSubstr("participant index 10: participants that name "
                                                    "this machine in `peers` do not find it"));
}

// Returns the masks of blocked signals of all threads except the calling one.
std::vector<std::uint64_t> masks_of_other_threads() {
  std::vector<std::uint64_t> out;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (task.path().filename() == std::to_string(::gettid())) continue;
    std::ifstream status(task.path() / "status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with("SigBlk:")) out.push_back(std::stoull(line.substr(7), nullptr, 16));
  }
  return out;
}

// The signals are for the host's handler, or for its sigwait.
TEST_F(NetworkTrouble, Thread_OfAParticipant_BlocksTheSignalsOfTheProcess) {
  const auto before = masks_of_other_threads().size();
  DomainParticipantOptions options{.domain_id = 76, .interfaces = {"lo"}};
  options.own_thread = true;
  const auto participant =
      DomainParticipant::create(std::move(options), PluginServices{clock, random, events});
  ASSERT_TRUE(participant);
  const auto masks = masks_of_other_threads();
  ASSERT_EQ(masks.size(), before + 1);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGUSR1, SIGALRM})
    EXPECT_TRUE(masks.back() >> (signal - 1) & 1) << signal;
}

TEST_F(NetworkTrouble, AddressOfNoInterface_IsSaid) {
  const auto refused = create({.domain_id = 74, .interfaces = {"192.0.2.1"}});
  ASSERT_EQ(code_of(refused), Code::rtps_address_not_here);
  EXPECT_THAT(refused.error().to_sentence(), ::testing::HasSubstr("ip -brief address"));
}

// The multicast group is one of IPv4.
TEST_F(NetworkTrouble, InterfaceWithoutMulticast_NeedsPeers) {
  const auto with_peers = create({.domain_id = 75, .interfaces = {"::1"}, .peers = {"::1"}});
  ASSERT_TRUE(with_peers) << with_peers.error().to_sentence();
  EXPECT_THAT(said(), ::testing::Contains(Code::rtps_no_multicast));
  EXPECT_EQ(code_of(create({.domain_id = 75, .interfaces = {"::1"}, .peers = {}})),
            Code::rtps_no_multicast);
}

TEST_F(NetworkTrouble, TwoInterfacesWithoutMulticast_NeedPeers) {
  EXPECT_EQ(code_of(create({.domain_id = 77, .interfaces = {"::1", "::1"}, .peers = {}})),
            Code::rtps_no_multicast);
  EXPECT_EQ(std::ranges::count(said(), Code::rtps_no_multicast), 0) << "the error says it";
}

}  // namespace
}  // namespace ddssec::rtps
