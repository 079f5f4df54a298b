// The keys of several readers of one participant.
#include "rtps/security/endpoint_keys.hpp"

#include "tests/unit/rtps_security/security_fixture.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

TEST(Joining, SeveralReadersOfOneParticipant_GetTheSameWriter) {
  Pair pair(everything(kEncryptOa));
  Listener second;
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  ASSERT_TRUE(pair.b->create_reader(square(qos), second, pair.world.now));
  pair.create_endpoints();
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 2; }));
  pair.write();
  EXPECT_TRUE(pair.world.run_until(
      [&] { return pair.b.listener.changes.size() == 1 && second.changes.size() == 1; }));
}

// The keyring's lists of receivers change by one receiver at a time.
TEST(Joining, ReadersThatComeAndGo_LeaveTheOthersTheirKeys) {
  Pair pair(everything(ProtectionKind::encrypt_with_origin_authentication));
  ASSERT_TRUE(pair.match());
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  std::array<Listener, 6> listeners;
  std::vector<Guid> readers;
  for (auto& listener : listeners)
    readers.push_back(*pair.b->create_reader(square(qos), listener, pair.world.now));
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 7; }));
  for (const std::size_t gone : {5u, 0u, 3u}) pair.b->remove(readers[gone], pair.world.now);
  pair.world.run(20);
  ASSERT_TRUE(pair.b->create_reader(square(qos), listeners[0], pair.world.now));
  ASSERT_TRUE(pair.world.run_until([&] { return pair.a.listener.matched == 5; }));
  pair.world.run(100);
  pair.write();
  for (const std::size_t left : {0u, 1u, 2u, 4u})
    EXPECT_TRUE(pair.world.run_until([&] { return listeners[left].changes.size() == 1; }, 300));
  EXPECT_EQ(pair.b.listener.changes.size(), 1u);
  EXPECT_EQ(pair.a->protection_counters().unsendable, 0u);
}

}  // namespace
}  // namespace ddssec::rtps
