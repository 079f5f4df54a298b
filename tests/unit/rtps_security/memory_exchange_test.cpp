// One side shares no memory. The other side reports this, and everything is sent by the network.
#include "rtps/security/memory_exchange.hpp"

#include <dirent.h>

#include "rtps/participant/shared_memory.hpp"
#include "tests/support/seeded_random.hpp"
#include "tests/unit/rtps_memory/hostile_sockets.hpp"
#include "tests/unit/rtps_security/shared_memory_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;
using ::testing::HasSubstr;
using enum ProtectionKind;

TEST(SharedMemory, Misspelled_Refused) {
  for (const auto& wrong : {shm("yes"), shm("ON"), shm(""), shm("on", "yes")}) {
    ManualClock clock{pki::kNow};
    test::RecordedEvents events;
    SeededRandom random(1);
    const PluginServices services{clock, random, events};
    const auto authentication = authentication::make_authentication(services);
    const auto access_control = access_control::make_access_control(services, {});
    const auto cryptography = cryptography::make_cryptography(services);
    const auto own = OwnSecurity::create({{*authentication, *access_control, *cryptography},
                                          Pair::both(properties_of("CN=a,O=Example", {}), wrong)},
                                         0, Node::candidate(1));
    EXPECT_EQ(code_of(own), Code::invalid_property);
  }
}

TEST(SharedMemory, Off_NothingIsOfferedOrSentDifferently) {
  for (const auto& off : {shm("off"), spi::PropertyList{}}) {
    Shared pair({.data = encrypt}, off, off);
    EXPECT_EQ(memory_of(pair.a->remote_participants().core()), nullptr);
    Volume volume(pair.world);
    EXPECT_FALSE(pair.share());
    EXPECT_GT(volume.take(), 3 * kLarge);
    EXPECT_TRUE(pair.has_all());
    EXPECT_TRUE(pair.a.events.is_quiet()) << pair.text();
    EXPECT_TRUE(pair.b.events.is_quiet()) << pair.text();
  }
}

TEST(SharedMemory, OffAtTheReader_AllGoesByNetworkWithOneEvent) {
  Shared pair({.data = encrypt}, shm(), shm("off"));
  for (int i = 0; i < 40; ++i) {
    EXPECT_FALSE(pair.share());
    pair.world.run(200);
  }
  EXPECT_TRUE(pair.has_all());
  EXPECT_EQ(pair.a.events.count(Code::rtps_memory_unused), 1) << pair.text();
  EXPECT_EQ(pair.b.events.count(Code::rtps_memory_unused), 0);
}

TEST(SharedMemory, OffAtTheReader_FirstOfferIsAnsweredAndTheEventSaysSo) {
  Shared pair({.data = encrypt}, shm(), shm("off"));
  EXPECT_FALSE(pair.share());
  EXPECT_THAT(pair.a.events.text(), HasSubstr("org.ddssec.shm is off there"));
}

TEST(SharedMemory, OffAtTheWriter_ReaderSaysSoOnce) {
  Shared pair({.data = encrypt}, shm("off"), shm());
  for (int i = 0; i < 40; ++i) {
    EXPECT_FALSE(pair.share());
    pair.world.run(200);
  }
  EXPECT_TRUE(pair.has_all());
  EXPECT_EQ(pair.b.events.count(Code::rtps_memory_unused), 1) << pair.text();
  EXPECT_THAT(pair.b.events.text(), HasSubstr("org.ddssec.shm is off there"));
  EXPECT_TRUE(pair.a.events.is_quiet()) << pair.a.events.text();
}

}  // namespace
}  // namespace ddssec::rtps
