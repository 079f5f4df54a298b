// Unprotected announcements, which anyone could have sent in the names of several participants, use
// up the room for announcements (T60 in docs/attacks.md).
#include "rtps/discovery/serialized.hpp"
#include "tests/attack/rtps/participant_access.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/span_writer.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr Rules kRules{.discovery = ProtectionKind::encrypt, .clear_topics = true};
constexpr std::uint8_t kNames = 9;

// All peers announce themselves to the victim only.
struct ClearRoom : ::testing::Test {
  ClearRoom() {
    for (std::uint8_t n = 1; n <= kNames + 2; ++n) {
      const auto subject = "CN=member " + std::to_string(n) + ",O=Example";
      nodes.push_back(std::make_unique<Node>(n, properties_of(subject, kRules), 1));
      world.nodes.push_back(nodes.back().get());
    }
    EXPECT_TRUE(world.run_until([&] {
      return std::ranges::all_of(nodes, [&](const auto& peer) {
        return peer == nodes.front() || (victim().knows(*peer) && peer->knows(victim()));
      });
    }));
    world.run(100);
  }
  Node& victim() { return *nodes.front(); }
  // Returns the peer that no forged announcement names.
  Node& honest() { return *nodes.back(); }
  static EndpointData reader(const GuidPrefix& prefix, std::uint32_t number) {
    return {
        .guid = {prefix,
                 {{static_cast<std::uint8_t>(0x40 | number >> 16),
                   static_cast<std::uint8_t>(number >> 8), static_cast<std::uint8_t>(number), 7}}},
        .topic_name = "T",
        .type_name = "T",
        .qos = default_reader_qos()};
  }
  // Announces in the name of that peer to the victim, in the clear.
  void announce_clearly(const GuidPrefix& prefix, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      Bytes buffer(4096);
      SpanWriter out(buffer);
      write_payload(out, reader(prefix, i));
      victim()->receive(forged(prefix, Data{kSubscriptionsReader,
                                            kSubscriptionsWriter,
                                            {i + 1},
                                            {},
                                            PayloadKind::data,
                                            out.view()}),
                        world.now, *Locator::parse("127.0.0.1", 7999));
    }
  }
  // Announces by the peer itself, protected with its keys.
  void announce_securely(Node& peer, std::uint32_t count) {
    auto& local = ParticipantAccess::local_endpoints(*peer.participant);
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto data = reader(peer->prefix(), i);
      Change change;
      change.key_hash = data.guid.octets();
      change.payload = Payload::copy_of(serialized(data));
      local.builtin()
          .writer(BuiltinTopic::subscriptions_secure)
          .write(std::move(change), world.now);
      if (i % 50 == 0) world.run(1);
    }
    world.run(200);
  }
  std::size_t known(Node& peer) {
    return victim()->remote_participants().all().at(peer->prefix()).endpoints.size();
  }
  void fill() {
    for (std::uint8_t n = 1; n <= kNames; ++n)
      announce_clearly(nodes[n]->participant->prefix(),
                       RemoteParticipants::kMaxEndpointsPerParticipant);
  }

  std::vector<std::unique_ptr<Node>> nodes;
  World world;
};

// Without room of their own, only about 200 would fit, into what each participant may announce in
// any case.
TEST_F(ClearRoom, InManyNames_LeavesSecureAnnouncementsTheirs) {
  fill();
  announce_securely(honest(), 1000);
  EXPECT_EQ(known(honest()), 1000u);
}

// The first secure announcement must not remove all clear ones of its participant.
TEST_F(ClearRoom, RoomOfOneParticipant_IsLeftToItsClearAnnouncements) {
  constexpr auto kMax = RemoteParticipants::kMaxEndpointsPerParticipant;
  announce_clearly(honest()->prefix(), kMax + 1);
  ASSERT_EQ(known(honest()), kMax);
  announce_securely(honest(), 300);
  EXPECT_EQ(known(honest()), kMax) << "the same endpoints, announced securely";
  announce_clearly(honest()->prefix(), 300);
  auto more = reader(honest()->prefix(), kMax + 5);
  Bytes buffer(4096);
  SpanWriter out(buffer);
  write_payload(out, more);
  victim()->receive(forged(honest()->prefix(), Data{kSubscriptionsReader,
                                                    kSubscriptionsWriter,
                                                    {kMax + 2},
                                                    {},
                                                    PayloadKind::data,
                                                    out.view()}),
                    world.now, *Locator::parse("127.0.0.1", 7999));
  EXPECT_EQ(known(honest()), kMax + 1) << "they count no more among the clear ones";
}

}  // namespace
}  // namespace ddssec::rtps
