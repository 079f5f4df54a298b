// Protection allocates nothing for a sample: neither writing it, nor sending it, nor taking it.
#include "tests/support/seeded_random.hpp"
#include "tests/unit/rtps/sample_flow.hpp"
#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// A secured DomainParticipant with plugins of its own.
struct Secured {
  Secured(ManualClock& clock, std::uint8_t seed, const std::string& subject, const Rules& rules,
          const spi::PropertyList& more = {})
      : random(seed),
        services{clock, random, events},
        authentication(authentication::make_authentication(services)),
        access_control(access_control::make_access_control(services)),
        cryptography(cryptography::make_cryptography(services)) {
    const SecurityPlugins plugins{*authentication, *access_control, *cryptography};
    auto options = undisturbed();
    options.security.emplace(plugins, Pair::both(properties_of(subject, rules), more));
    participant = *DomainParticipant::create(std::move(options), services);
  }
  test::RecordedEvents events;
  SeededRandom random;
  PluginServices services;
  std::unique_ptr<spi::Authentication> authentication;
  std::unique_ptr<spi::AccessControl> access_control;
  std::unique_ptr<spi::Cryptography> cryptography;
  std::unique_ptr<DomainParticipant> participant;
};

std::int64_t allocations(ProtectionKind kind, const Flow& flow) {
  ManualClock clock{pki::kNow};
  const auto rules = everything(kind);
  Secured a(clock, 1, "CN=alice,O=Example", rules), b(clock, 2, "CN=bob,O=Example", rules);
  return SampleFlow<Keyed>(clock, *a.participant, *b.participant, flow).allocations();
}

TEST(Allocation, Protection_AddsNone) {
  for (auto kind : {ProtectionKind::sign, ProtectionKind::encrypt,
                    ProtectionKind::encrypt_with_origin_authentication}) {
    EXPECT_EQ(allocations(kind, {HistoryKind::keep_all, 64, 10'000}), 0) << to_string(kind);
    EXPECT_EQ(allocations(kind, {HistoryKind::keep_last, 40'000, 2'000}), 0) << to_string(kind);
  }
}

TEST(Allocation, SharedMemory_AddsNone) {
  const spi::PropertyList on{{std::string(spi::property::kSharedMemory), "on", false}};
  for (const auto& rules : {everything(ProtectionKind::encrypt), Rules{}}) {
    ManualClock clock{pki::kNow};
    Secured a(clock, 1, "CN=alice,O=Example", rules, on),
        b(clock, 2, "CN=bob,O=Example", rules, on);
    SampleFlow<Keyed> flow(clock, *a.participant, *b.participant,
                           {HistoryKind::keep_last, 100'000, 2'000});
    for (int i = 0; i < 20 && !a.events.has(Code::rtps_memory_used); ++i)
      static_cast<void>(flow.allocations());
    ASSERT_TRUE(a.events.has(Code::rtps_memory_used)) << a.events.text();
    EXPECT_EQ(flow.allocations(), 0);
  }
}

}  // namespace
}  // namespace ddssec::rtps
