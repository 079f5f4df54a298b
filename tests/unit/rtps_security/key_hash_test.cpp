// What a key hash reveals about a key if payloads are encrypted (DDS-Security 1.2, clause 7.4.4).
#include <filesystem>
#include <functional>
#include <unistd.h>

#include "rtps/durability/durable_store.hpp"
#include "tests/unit/rtps_security/secured_dcps.hpp"

namespace ddssec::rtps {

// This type has the same octets, and hashes the other member.
struct MisnamedSensor {
  std::int32_t id = 0;
  std::int32_t value = 0;
};
template <>
struct TypeTraits<MisnamedSensor> {
  static constexpr std::string_view type_name = "Sensor";
  static constexpr auto extensibility = Extensibility::appendable;
  template <class Self, class Visit>
  static void members(Self& s, Visit&& visit) {
    visit(named("id", s.id), named("value", key(s.value)));
  }
};

namespace {

using namespace testing;

constexpr auto kEncrypt = ProtectionKind::encrypt;

// Returns the hash of instance 7 that its writer passes on to be sent and stored.
KeyHash hash_under(const Rules& rules) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("ddssec-key-" + std::to_string(::getpid()));
  std::filesystem::create_directory(folder);
  const std::string file = folder / "samples";
  ManualClock clock{pki::kNow};
  {
    Secured end("CN=alice,O=Example", rules, clock, file);
    auto qos = default_writer_qos();
    qos.durability = DurabilityKind::persistent;
    EXPECT_TRUE(end.writer(qos).write({7, 1}));
  }
  test::RecordedEvents events;
  KeyHash out{};
  if (auto store = DurableStore::open(file, events)) {
    const auto stream =
        (*store)->open_stream({.domain = static_cast<std::uint32_t>(Secured::kDomain),
                               .topic = "Sensors",
                               .type = "Sensor"},
                              {}, Moment{});
    EXPECT_TRUE(stream && stream->history.size() == 1);
    if (stream && !stream->history.empty()) out = stream->history[0].key_hash.value_or(KeyHash{});
  }
  std::filesystem::remove_all(folder);
  return out;
}

TEST(KeyHashes, EncryptedPayloads_DoNotShowShortKeys) {
  const KeyHash plain = {0, 0, 0, 7};
  const auto digest = md5(Bytes{0, 0, 0, 7});
  EXPECT_EQ(hash_under({}), plain);
  EXPECT_EQ(hash_under({.data = ProtectionKind::sign}), plain);
  EXPECT_EQ(hash_under({.data = kEncrypt}), digest);
  EXPECT_EQ(hash_under({.metadata = kEncrypt, .data = kEncrypt}), digest);
}

// True if `done` becomes true within five seconds of the clock, while both participants are polled.
bool comes_true(ManualClock& clock, Secured& a, Secured& b, const std::function<bool()>& done) {
  for (int i = 0; i < 500 && !done(); ++i) {
    clock.advance(10ms);
    for (int n = 0; n < 4; ++n) a.participant->poll(0ms), b.participant->poll(0ms);
  }
  return done();
}

bool are_matched(const auto& writer, const auto& reader) {
  return writer.matched_subscription_data(reader.guid()) &&
         reader.matched_publication_data(writer.guid());
}

// No signature covers the hash beside a payload, so anyone could choose the instance.
TEST(KeyHashes, ProtectedPayloads_HaveThemComputedAnew) {
  for (const auto kind : {ProtectionKind::sign, kEncrypt}) {
    ManualClock clock{pki::kNow};
    Secured a("CN=alice,O=Example", {.data = kind}, clock);
    Secured b("CN=bob,O=Example", {.data = kind}, clock);
    auto offered = default_writer_qos();
    offered.durability = DurabilityKind::transient;  // samples of such a writer carry the hash
    auto& topic = *a.participant->create_topic<MisnamedSensor>("Others").value();
    auto& writer =
        **a.participant->create_publisher().create_datawriter<MisnamedSensor>(topic, offered);
    auto wanted = default_reader_qos();
    wanted.reliability.kind = ReliabilityKind::reliable;
    wanted.history.kind = HistoryKind::keep_all;
    b.topic = b.participant->create_topic<Sensor>("Others").value();
    auto& reader = b.reader(wanted);
    std::vector<InstanceHandle> came;
    const auto eventually = [&](const auto& done) { return comes_true(clock, a, b, done); };
    ASSERT_TRUE(eventually([&] { return are_matched(writer, reader); })) << a.events.text();
    ASSERT_TRUE(writer.write({7, 1}));
    ASSERT_TRUE(writer.write({8, 1}));
    ASSERT_TRUE(eventually([&] {
      while (const auto sample = reader.take_next_sample())
        came.push_back(sample->info.instance_handle);
      return came.size() == 2;
    }));
    EXPECT_EQ(came, (std::vector{reader.lookup_instance({7, 0}), reader.lookup_instance({8, 0})}));
  }
}

TEST(KeyHashes, EncryptedPayloads_NameTheInstanceThatEnds) {
  for (const auto& rules : {Rules{.data = kEncrypt}, everything(kEncrypt)}) {
    ManualClock clock{pki::kNow};
    Secured a("CN=alice,O=Example", rules, clock), b("CN=bob,O=Example", rules, clock);
    auto qos = default_reader_qos();
    qos.reliability.kind = ReliabilityKind::reliable;
    qos.history.kind = HistoryKind::keep_all;
    auto& writer = a.writer(default_writer_qos());
    auto& reader = b.reader(qos);
    const auto eventually = [&](const auto& done) { return comes_true(clock, a, b, done); };
    ASSERT_TRUE(eventually([&] { return are_matched(writer, reader); })) << a.events.text();
    ASSERT_TRUE(writer.write({7, 1}));
    ASSERT_TRUE(writer.write({8, 1}));
    ASSERT_TRUE(writer.dispose({7, 1}));
    std::vector<std::pair<InstanceHandle, bool>> came;
    ASSERT_TRUE(eventually([&] {
      while (const auto sample = reader.take_next_sample())
        came.emplace_back(sample->info.instance_handle, sample->info.valid_data);
      return came.size() == 3;
    }));
    const auto seven = reader.lookup_instance({7, 0}), eight = reader.lookup_instance({8, 0});
    EXPECT_EQ(came, (std::vector<std::pair<InstanceHandle, bool>>{
                        {seven, true}, {seven, false}, {eight, true}}));
  }
}

}  // namespace
}  // namespace ddssec::rtps
