// How many octets a participant sends to others for those that a stranger sends to it (T60 in
// docs/attacks.md).
#include "rtps/discovery/serialized.hpp"
#include "rtps/security/peer_handshake.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/acknack.hpp"
#include "wire/heartbeat.hpp"
#include "wire/info_source.hpp"
#include "wire/nack_frag.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

// An attacker at 192.0.2.66 that sends to one participant, and the octets that this participant
// sends to the four addresses of the victim, 192.0.2.1.
class Reflection {
 public:
  explicit Reflection(Node& node) : node_(node) {
    world_.nodes = {&node};
    world_.run(1);
  }
  void send(BytesView datagram, const Locator& source = *Locator::parse("192.0.2.66", 7410)) {
    in_ += datagram.size();
    node_->receive(datagram, world_.now, source);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      for (const auto& [port, octets] : node_.post.sent) {
        out_ += port >= 7990 && port < 7994 ? octets.size() : 0;
        if (port == 7410) ears_.hear(octets);
      }
      world_.run(1);
    }
  }
  // Returns the data of a participant that names the victim's addresses.
  static ParticipantData data_of(const GuidPrefix& name, VendorId vendor) {
    auto data = secured_data(name);
    data.vendor = vendor;
    data.metatraffic_unicast.clear();
    for (std::uint16_t port = 7990; port < 7994; ++port)
      data.metatraffic_unicast.push_back(*Locator::parse("192.0.2.1", port));
    data.default_unicast = data.metatraffic_unicast;
    return data;
  }
  // Returns what was sent to the attacker's own address.
  const Eavesdropper& ears() const { return ears_; }
  std::size_t in() const { return in_; }
  std::size_t out() const { return out_; }
  double ratio() const { return static_cast<double>(out_) / static_cast<double>(in_); }
  MonotonicTime now() const { return world_.now; }

 private:
  Node& node_;
  World world_;
  Eavesdropper ears_;
  std::size_t in_ = 0, out_ = 0;
};

constexpr VendorId kVendors[] = {kVendorDdssec, kVendorCyclone, kVendorFastDds, {{1, 1}}};

GuidPrefix name_of(std::uint8_t octet) { return GuidPrefix::from(Bytes(12, octet)); }

Node secured_node(const Rules& rules = {}) {
  return Node(1, properties_of("CN=alice,O=Example", rules));
}

void expect_below_three(Reflection& reflection) {
  EXPECT_GT(reflection.out(), 0u);
  EXPECT_LT(reflection.out(), 3 * reflection.in()) << reflection.ratio();
}

// The attacker announces a participant with four addresses of the victim, and sends nothing else.
// Its GUID is once below ours, and once above ours, where we begin the handshake. Without a limit,
// the victim got 464 times as many octets.
TEST(Amplification, OneAnnouncement_IsBelowThree) {
  for (const auto& vendor : kVendors)
    for (const std::uint8_t name : {0x00, 0xff}) {
      auto node = secured_node();
      Reflection reflection(node);
      reflection.send(announcement(Reflection::data_of(name_of(name | 1), vendor)));
      reflection.run(12'000);
      expect_below_three(reflection);
    }
}

TEST(Amplification, OneAnnouncementWithoutSecurity_IsBelowThree) {
  for (const auto& vendor : kVendors) {
    Node node(2);
    static_cast<void>(node->create_writer(square(default_writer_qos()), node.listener, 1s));
    Reflection reflection(node);
    reflection.send(announcement(Reflection::data_of(name_of(1), vendor)));
    reflection.run(12'000);
    expect_below_three(reflection);
  }
}

constexpr EntityId kAnnouncedReader{{0, 0, 1, 0x07}};

// Returns one datagram: a participant with the victim's addresses, and its reader.
Bytes participant_and_reader(const GuidPrefix& name, VendorId vendor,
                             ReliabilityKind reliability = ReliabilityKind::best_effort) {
  auto participant = Reflection::data_of(name, vendor);
  participant.identity_token = participant.permissions_token = {};
  participant.lease_duration = kDurationInfinite;
  EndpointData reader;
  reader.guid = {name, kAnnouncedReader};
  reader.topic_name = "Square";
  reader.type_name = "ShapeType";
  reader.qos = default_reader_qos();
  reader.qos.reliability.kind = reliability;
  reader.unicast = participant.default_unicast;
  Bytes first(4096), second(4096);
  SpanWriter of_participant(first), of_reader(second);
  write_payload(of_participant, participant);
  write_payload(of_reader, reader);
  return forged(name,
                Data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, of_participant.view()},
                Data{kSubscriptionsReader,
                     kSubscriptionsWriter,
                     {1},
                     {},
                     PayloadKind::data,
                     of_reader.view()});
}

// Messages to all readers go to the announced addresses, too. Without a limit, the victim got every
// sample, at each of its addresses.
TEST(Amplification, SamplesForAnAnnouncedReader_AreBelowThree) {
  for (const auto& vendor : kVendors) {
    Node node(2);
    const auto writer =
        node->create_writer(square(default_writer_qos()), node.listener, 1s).value();
    Reflection reflection(node);
    reflection.send(participant_and_reader(name_of(1), vendor));
    ASSERT_EQ(node.listener.matched, 1);
    for (int i = 0; i < 1000; ++i) {
      Change change;
      change.payload = payload(1000);
      node->local_endpoints().writer(writer)->write(std::move(change), reflection.now());
      reflection.run(1);
    }
    expect_below_three(reflection);
  }
}

// Requests of a reliable reader ask for repairs: of samples, and of fragments. Each has another
// base and another count, so that none is a repetition. They are the smallest that ask for much.
void send_requests(Reflection& reflection, const GuidPrefix& name, const EntityId& writer, int i) {
  SequenceNumberSet missing(SequenceNumber{1 + i % 2});
  for (std::int64_t number = 2; number < 60; ++number) missing.insert(SequenceNumber{number});
  FragmentNumberSet fragments(FragmentNumber{1});
  for (std::uint32_t number = 1; number < 30; ++number) fragments.insert(FragmentNumber{number});
  reflection.send(forged(name, AckNack{kAnnouncedReader, writer, missing, i, false}));
  reflection.send(
      forged(name, NackFrag{kAnnouncedReader, writer, SequenceNumber{60}, fragments, i}));
}

void expect_requests_below_three(Node node, VendorId vendor) {
  auto qos = default_writer_qos();
  qos.durability = DurabilityKind::transient_local;
  qos.history.kind = HistoryKind::keep_all;
  const auto writer = node->create_writer(square(qos), node.listener, 1s).value();
  Reflection reflection(node);
  const auto write = [&](std::size_t octets) {
    Change change;
    change.payload = payload(octets);
    node->local_endpoints().writer(writer)->write(std::move(change), reflection.now());
  };
  for (int i = 0; i < 59; ++i) write(4'000);
  write(1'000'000);
  reflection.send(participant_and_reader(name_of(1), vendor, ReliabilityKind::reliable));
  reflection.run(12'000);  // where participants authenticate, until this one is admitted without
  ASSERT_EQ(node.listener.matched, 1) << node.events.text();
  for (int i = 1; i <= 500; ++i) {
    send_requests(reflection, name_of(1), writer.entity, i);
    reflection.run(1);
  }
  reflection.run(3'000);
  expect_below_three(reflection);
}

// Once without security, and once where participants need not authenticate.
TEST(Amplification, RequestsOfAnAnnouncedReader_AreBelowThree) {
  for (const auto& vendor : kVendors) {
    expect_requests_below_three(Node(2), vendor);
    expect_requests_below_three(secured_node({.allow_unauthenticated = true, .open_topics = true}),
                                vendor);
  }
}

TEST(Amplification, AssertionsOfLiveliness_AreBelowThree) {
  for (const auto& vendor : kVendors) {
    Node node(2);
    auto qos = default_writer_qos();
    qos.liveliness.lease_duration = {{1, 0}};
    static_cast<void>(node->create_writer(square(qos), node.listener, 1s));
    Reflection reflection(node);
    reflection.send(participant_and_reader(name_of(1), vendor));
    reflection.run(12'000);
    expect_below_three(reflection);
  }
}

TEST(Amplification, RepeatedAnnouncements_AreBelowThree) {
  for (const auto& vendor : kVendors) {
    auto node = secured_node();
    Reflection reflection(node);
    for (int i = 0; i < 10; ++i) {
      reflection.send(announcement(Reflection::data_of(name_of(0xff), vendor)));
      reflection.run(300);
    }
    reflection.run(12'000);
    expect_below_three(reflection);
  }
}

// An attacker can send further datagrams in the announced name. None of them causes more than three
// times its octets either.
TEST(Amplification, EverythingElseInTheAnnouncedName_IsBelowThree) {
  const auto name = name_of(0xff);
  for (const auto& vendor : kVendors) {
    auto node = secured_node();
    Reflection reflection(node);
    reflection.send(announcement(Reflection::data_of(name, vendor)));
    const spi::Token request{"DDS:Auth:PKI-DH:1.0+AuthReq", {}, {{"future_challenge", Bytes(32)}}};
    for (int i = 0; i < 300; ++i) {
      reflection.send(
          handshake_message(name, node->prefix(), request, message_class::kAuthRequest));
      reflection.send(
          handshake_message(name, node->prefix(), {"DDS:Auth:PKI-DH:1.0+Reply", {}, {}}));
      reflection.send(forged(name, InfoDestination{node->prefix()},
                             Heartbeat{{}, kPublicationsWriter, {1}, {9}, i, false, false, {}}));
      reflection.run(1);
    }
    reflection.run(3000);
    expect_below_three(reflection);
  }
}

// The attacker also names an address of its own, to which a challenge is sent. It repeats the
// challenge with the victim's address as the source.
TEST(Amplification, ChallengeThatWasHeardElsewhere_IsBelowThree) {
  const auto name = name_of(0xff);
  const auto victim = *Locator::parse("192.0.2.1", 7990);
  auto node = secured_node();
  Reflection reflection(node);
  auto data = Reflection::data_of(name, kVendorDdssec);
  data.metatraffic_unicast.front() = *Locator::parse("192.0.2.66", 7410);
  reflection.send(announcement(data));
  reflection.send(announcement(data), victim);
  reflection.run(100);
  ASSERT_NE(reflection.ears().heard("+AuthReq"), nullptr);
  const auto* heard =
      spi::find_binary_property(*reflection.ears().heard("+AuthReq"), PeerHandshake::kChallenge);
  ASSERT_NE(heard, nullptr);
  const spi::Token repeated{
      "DDS:Auth:PKI-DH:1.0+AuthReq",
      {},
      {{"future_challenge", Bytes(32)}, {std::string(PeerHandshake::kHeardChallenge), *heard}}};
  reflection.send(handshake_message(name, node->prefix(), repeated, message_class::kAuthRequest),
                  victim);
  reflection.run(12'000);
  EXPECT_NE(reflection.ears().heard("+Req"), nullptr) << "its own address is proven";
  expect_below_three(reflection);
}

// A datagram with several names counts for one of them only.
TEST(Amplification, ManyNamesInOneDatagram_AreBelowThree) {
  auto node = secured_node();
  Reflection reflection(node);
  Bytes buffer(65536);
  SpanWriter out(buffer);
  write(out, Header{});
  for (std::uint8_t name = 0xd0; name < 0xf0; ++name) {
    Bytes payload(4096);
    SpanWriter content(payload);
    write_payload(content, Reflection::data_of(name_of(name), kVendorDdssec));
    Header source;
    source.prefix = name_of(name);
    write(out, InfoSource{source});
    write(out, Data{kSpdpReader, kSpdpWriter, {1}, {}, PayloadKind::data, content.view()});
  }
  reflection.send(out.view());
  reflection.run(12'000);
  expect_below_three(reflection);
}

// Requests are not signed, so an attacker that heard one can make any number of them in that name.
TEST(Amplification, RecordedRequests_AreBelowThree) {
  Pair pair({});
  Eavesdropper ears;
  auto& begins = pair.a->prefix() < pair.b->prefix() ? pair.a : pair.b;
  auto& answers = &begins == &pair.a ? pair.b : pair.a;
  pair.world.filter = [&](const Node&, Bytes datagram) {
    ears.hear(datagram);
    return ears.heard("+Req") != nullptr ? std::vector<Bytes>{} : one(std::move(datagram));
  };
  ASSERT_TRUE(pair.world.run_until([&] { return ears.heard("+Req") != nullptr; }, 100));
  auto token = *ears.heard("+Req");
  Reflection reflection(answers);
  reflection.send(announcement(Reflection::data_of(begins->prefix(), kVendorDdssec)));
  std::mt19937 random(1);
  for (int i = 0; i < 20; ++i) {
    for (auto& octet : *field(token, "challenge1")) octet = static_cast<std::uint8_t>(random());
    reflection.send(handshake_message(begins->prefix(), answers->prefix(), token));
    reflection.run(10);
  }
  reflection.run(12'000);
  expect_below_three(reflection);
}

// The requests are in the name of a reader, and nothing is protected. Without a limit, the answers
// had 338 times their octets.
TEST(Amplification, ManyRequestsInOneDatagram_AreBounded) {
  Pair pair({});
  ASSERT_TRUE(pair.match());
  auto& writer = *pair.a->local_endpoints().writer(pair.writer);
  pair.world.filter = [](const Node&, Bytes) { return std::vector<Bytes>{}; };
  for (int i = 0; i < 100; ++i) pair.write(4000);
  Bytes buffer(65536);
  SpanWriter out(buffer);
  Header header;
  header.prefix = pair.b->prefix();
  write(out, header);
  std::int32_t count = 1000;
  while (out.size() < 63'000) {
    SequenceNumberSet missing(SequenceNumber{1 + count % 2});
    for (std::int64_t number = 2; number < 90; ++number) missing.insert(SequenceNumber{number});
    write(out, AckNack{pair.reader.entity, pair.writer.entity, missing, ++count, false});
  }
  const auto datagram = to_bytes(out.view());
  pair.a.post.sent.clear();
  pair.a->receive(datagram, pair.world.now);
  std::size_t answered = 0;
  for (const auto& [port, octets] : pair.a.post.sent) answered += octets.size();
  EXPECT_GT(answered, datagram.size());
  EXPECT_LT(answered, 6 * datagram.size());
  EXPECT_FALSE(writer.all_acknowledged());
}

}  // namespace
}  // namespace ddssec::rtps
