// Endpoints that change their partitions.
#include "rtps/participant/partition_change.hpp"

#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// Otherwise readers that have its keys would read on, whatever they may read in the other
// partitions.
TEST(KeyRevision, WriterMovedToOtherPartitions_CausesOne) {
  Trio trio(revising({.data = kEncrypt, .partitions = "*"}));
  ASSERT_TRUE(trio.match()) << trio.text();
  auto reading = default_reader_qos();
  reading.reliability.kind = ReliabilityKind::reliable;
  reading.history.kind = HistoryKind::keep_all;
  reading.partition = {"secret"};
  ASSERT_TRUE(trio.b->create_reader(square(reading), trio.b.listener, trio.world.now));
  Recorder recorder(trio.stolen);
  record(trio, recorder);
  auto writing = default_writer_qos();
  writing.history.kind = HistoryKind::keep_all;
  writing.liveliness.lease_duration = Duration{{1, 0}};
  writing.partition = {"secret"};
  ASSERT_TRUE(trio.a->change_qos(trio.writer, writing, trio.world.now));
  ASSERT_TRUE(
      trio.world.run_until([&] { return trio.a.events.has(Code::rtps_keys_revised); }, 1500))
      << trio.text();
  trio.world.run(100);
  recorder.forget();
  trio.write();
  EXPECT_TRUE(trio.bob_has_all()) << trio.text();
  EXPECT_GT(recorder.payloads.seen, 0);
  EXPECT_EQ(recorder.payloads.opened, 0);
}

TEST(KeyRevision, WithoutIt_AProtectedWriter_StaysInItsPartitions) {
  const auto moved = [](const Rules& rules) {
    Trio trio(rules);
    EXPECT_TRUE(trio.match());
    auto qos = default_writer_qos();
    qos.history.kind = HistoryKind::keep_all;
    qos.partition = {"secret"};
    const auto status = trio.a->change_qos(trio.writer, qos, trio.world.now);
    if (!status) {
      EXPECT_EQ(status.error().details().field, "PARTITION");
    }
    return code_of(status);
  };
  EXPECT_EQ(moved({.data = kEncrypt, .partitions = "*"}), Code::rtps_immutable_policy);
  EXPECT_EQ(moved({.metadata = kEncrypt, .partitions = "*"}), Code::rtps_immutable_policy);
  EXPECT_EQ(moved({.rtps = kEncrypt, .partitions = "*"}), Code{}) << "the topic has no keys";
  EXPECT_EQ(moved({.data = kEncrypt, .access_control = false}), Code{}) << "all may read it";
}

// The call itself must fail. It is not enough that the remote side refuses.
TEST(OwnPermissions, PartitionsThatTheyDoNotAllow_AreRefusedForExistingEndpoints) {
  Pair pair(revising({.data = kEncrypt, .partitions = "a*"}));
  auto writing = default_writer_qos();
  auto reading = default_reader_qos();
  writing.partition = reading.partition = {"a"};
  auto& node = pair.a;
  const auto writer = node->create_writer(square(writing), node.listener, pair.world.now);
  const auto reader = node->create_reader(square(reading), node.listener, pair.world.now);
  ASSERT_TRUE(writer && reader);
  for (auto [endpoint, qos] : {std::pair(*writer, writing), std::pair(*reader, reading)}) {
    qos.partition = {"b"};
    const auto refused = node->change_qos(endpoint, qos, pair.world.now);
    ASSERT_FALSE(refused.has_value());
    EXPECT_EQ(refused.error().code(),
              endpoint == *writer ? Code::publish_not_allowed : Code::subscribe_not_allowed)
        << refused.error().to_sentence();
    EXPECT_EQ(node->local_endpoints().find(endpoint.entity)->qos.partition,
              (std::vector<std::string>{"a"}));
    qos.partition = {"ab"};
    EXPECT_TRUE(node->change_qos(endpoint, qos, pair.world.now));
  }
}

}  // namespace
}  // namespace ddssec::rtps
