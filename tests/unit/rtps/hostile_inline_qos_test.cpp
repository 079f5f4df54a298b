// Inline QoS of every kind and length, in the name of a writer that matched. The reader uses all of
// it. It goes on, and samples of honest writers arrive unchanged.
#include "rtps/transport/ports.hpp"
#include "rtps/transport/udp_socket.hpp"
#include "tests/unit/rtps/dcps_fixture.hpp"
#include "wire/data.hpp"
#include "wire/parameter_list.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr Presentation kByGroup{PresentationScope::group, true, true};

Qos durable() {
  auto qos = reliable();
  qos.durability = DurabilityKind::transient;
  return qos;
}

// Returns a DATA with that inline QoS, whatever it contains.
Bytes forged(const Guid& writer, std::int64_t number, BytesView inline_qos, Endian endian) {
  std::array<std::uint8_t, 512> buffer{};
  SpanWriter out(buffer, endian);
  out.write_bytes(as_bytes("RTPS"));
  out.write_bytes(kProtocolVersion.view());
  out.write_bytes(kVendorDdssec.view());
  out.write_bytes(writer.prefix.octets);
  const std::array<std::uint8_t, 2> head = {
      0x15, static_cast<std::uint8_t>(0x06 | (endian == Endian::little ? 1 : 0))};
  out.write_bytes(head);
  out.write(static_cast<std::uint16_t>(20 + inline_qos.size() + 4));
  out.write(std::uint16_t{0});
  out.write(std::uint16_t{16});
  out.write_bytes(kEntityIdUnknown.octets);
  out.write_bytes(writer.entity.octets);
  write_sequence_number(out, {number});
  out.write_bytes(inline_qos);
  const std::array<std::uint8_t, 4> payload = {0, 1, 0, 0};
  out.write_bytes(payload);
  EXPECT_FALSE(out.overflowed());
  return to_bytes(out.view());
}

// Returns a parameter of `size` octets that claims to have `claimed`, with or without a sentinel.
Bytes list_of(ParameterId id, std::size_t size, std::size_t claimed, std::uint8_t fill, bool ends,
              Endian endian) {
  std::array<std::uint8_t, 128> buffer{};
  SpanWriter out(buffer, endian);
  out.write(id);
  out.write(static_cast<std::uint16_t>(claimed));
  out.write_bytes(Bytes(size, fill));
  if (ends) write_sentinel(out);
  return to_bytes(out.view());
}

constexpr ParameterId kIds[] = {0x0035, 0x0055, 0x0056, 0x0061, 0x0063, 0x0064,
                                0x0065, 0x0070, 0x0071, 0x0074, 0x7fff};

struct HostileInlineQos : Polled {
  template <class F>
  void each(F&& f) {
    for (const auto id : kIds)
      for (const std::size_t size : {0, 4, 8, 12, 16, 20, 24, 28, 64})
        for (const std::uint8_t fill : {0x00, 0x01, 0x7f, 0x80, 0xff})
          for (const auto endian : {Endian::little, Endian::big}) {
            f(list_of(id, size, size, fill, true, endian), endian);
            f(list_of(id, size, size + 4, fill, true, endian), endian);
            f(list_of(id, size, 0xfffc, fill, false, endian), endian);
          }
  }
};

TEST_P(HostileInlineQos, HostileParameters_StopNoReaderAndSpareHonestWriters) {
  Publisher& liar = a.participant->create_publisher({.presentation = kByGroup});
  Publisher& honest = a.participant->create_publisher({.presentation = kByGroup});
  Subscriber& subscriber = b.participant->create_subscriber({.presentation = kByGroup});
  auto& lying = **liar.create_datawriter<Reading>(*a.topic, durable());
  auto& writer = **honest.create_datawriter<Reading>(*a.topic, durable());
  auto& reader = **subscriber.create_datareader<Reading>(*b.topic, durable());
  ASSERT_TRUE(match(lying, reader) && match(writer, reader));
  const auto socket = *UdpSocket::on_interface(*Locator::parse("127.0.0.1", 0));
  const auto port = ports::user(b.participant->domain_id(), b.participant->index());
  const Locator to[] = {*Locator::parse("127.0.0.1", static_cast<std::uint16_t>(port))};
  std::int64_t number = 0;
  each([&](const Bytes& list, Endian endian) {
    socket.send(forged(lying.guid(), ++number, list, endian), to);
    if (number % 16 == 0) b.participant->poll(0ms);
  });
  EXPECT_GT(number, 2900);
  run(50ms);
  ASSERT_TRUE(honest.begin_coherent_changes());
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(writer.write({"north", i}));
  ASSERT_TRUE(honest.end_coherent_changes());
  std::vector<std::int64_t> got;
  EXPECT_TRUE(eventually([&] {
    if (!subscriber.begin_access()) return false;
    Samples<Reading> samples;
    EXPECT_TRUE(reader.take(samples));
    // The attacker's message may appear as a sample without data.
    for (const auto& sample : samples)
      if (sample.data.sensor == "north") got.push_back(sample.data.value);
    return subscriber.end_access().has_value() && got.size() >= 3;
  }));
  EXPECT_EQ(got, (std::vector<std::int64_t>{0, 1, 2}));
}

// Only the payload could say which instance it is, and it is no key.
TEST_P(HostileInlineQos, ADisposeWhoseKeyCannotBeRead_IsReportedAndChangesNothing) {
  auto& writer = a.writer(reliable());
  auto& reader = b.reader(reliable());
  ASSERT_TRUE(match(writer, reader));
  const auto socket = *UdpSocket::on_interface(*Locator::parse("127.0.0.1", 0));
  const auto port = ports::user(b.participant->domain_id(), b.participant->index());
  const Locator to[] = {*Locator::parse("127.0.0.1", static_cast<std::uint16_t>(port))};
  const Bytes payload = {0, 9, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8};
  const Data data{kEntityIdUnknown,
                  writer.guid().entity,
                  {1},
                  {{}, {.disposed = true}, {}, {}, {}},
                  PayloadKind::key,
                  payload};
  std::array<std::uint8_t, 256> buffer{};
  SpanWriter out(buffer);
  Header header;
  header.prefix = writer.guid().prefix;
  write(out, header);
  write(out, data);
  socket.send(out.view(), to);
  EXPECT_TRUE(eventually([&] { return reader.malformed() == 1; }));
  Samples<Reading> samples;
  EXPECT_EQ(reader.take(samples), 0u);
  const std::lock_guard held(events.mutex);
  const auto report = std::ranges::find(events.all, Code::rtps_key_unreadable,
                                        [](const Event& event) { return event.error.code(); });
  ASSERT_NE(report, events.all.end());
  EXPECT_EQ(report->error.details().found, "12 octets that begin 00090000");
  EXPECT_EQ(report->guid, writer.guid().to_string());
}

INSTANTIATE_TEST_SUITE_P(Over, HostileInlineQos, ::testing::Values(Way::network), testing::name_of);

}  // namespace
}  // namespace ddssec::rtps
