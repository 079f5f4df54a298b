// Every message of two participants that find each other and exchange a sample is cut at each
// octet, and each field is set to extreme values. All forms of the first three messages of each
// length and sender go to one running pair, before the honest message does. Messages whose source
// is a prefix of zeros go to a pair without security.
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/acknack.hpp"
#include "wire/gap.hpp"
#include "wire/heartbeat.hpp"
#include "wire/nack_frag.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr auto kSign = ProtectionKind::sign;
constexpr auto kEncrypt = ProtectionKind::encrypt;
constexpr auto kEncryptOa = ProtectionKind::encrypt_with_origin_authentication;

using Use = std::function<void(BytesView)>;

// The place of the length of the last submessage, and of the first octet that it counts. There is
// none if the message is not little-endian, or if the submessage goes on to the end of the
// datagram.
struct LastLength {
  std::size_t at = 0, begin = 0;
};
std::optional<LastLength> last_length(BytesView datagram) {
  for (std::size_t at = kHeaderSize; at + 4 <= datagram.size();) {
    const std::size_t length = datagram[at + 2] | datagram[at + 3] << 8;
    const auto end = at + 4 + length;
    if ((datagram[at + 1] & 1) == 0 || length == 0 || end > datagram.size()) return std::nullopt;
    if (end == datagram.size()) return LastLength{at + 2, at + 4};
    at = end;
  }
  return std::nullopt;
}

// Uses the datagram cut at each octet: once as it is, and once with the length of its last
// submessage changed to fit, so that the reader of its content sees the cut.
void each_truncation(const Bytes& datagram, const Use& use) {
  for (std::size_t size = 0; size < datagram.size(); ++size) use(BytesView(datagram).first(size));
  const auto length = last_length(datagram);
  if (!length) return;
  auto cut = datagram;
  for (std::size_t size = length->begin; size < datagram.size(); ++size) {
    const auto left = size - length->begin;
    cut[length->at] = static_cast<std::uint8_t>(left);
    cut[length->at + 1] = static_cast<std::uint8_t>(left >> 8);
    use(BytesView(cut).first(size));
  }
}

// Uses the datagram with each field of two and of four octets set to extreme values, in either byte
// order.
void each_extreme(const Bytes& datagram, const Use& use) {
  auto changed = datagram;
  const auto try_at = [&](std::size_t at, const auto& octets) {
    const auto place = changed.begin() + static_cast<std::ptrdiff_t>(at);
    const auto honest = datagram.begin() + static_cast<std::ptrdiff_t>(at);
    const auto size = static_cast<std::ptrdiff_t>(octets.size());
    if (std::equal(octets.begin(), octets.end(), honest)) return;
    std::ranges::copy(octets, place);
    use(changed);
    std::copy(honest, honest + size, place);
  };
  using Two = std::array<std::uint8_t, 2>;
  using Four = std::array<std::uint8_t, 4>;
  static constexpr Two kTwo[] = {{0, 0}, {1, 0}, {0xff, 0x7f}, {0, 0x80}, {0xff, 0xff}};
  static constexpr Four kFour[] = {
      {0, 0, 0, 0},    {0xff, 0xff, 0xff, 0x7f}, {0x7f, 0xff, 0xff, 0xff},
      {0, 0, 0, 0x80}, {0x80, 0, 0, 0},          {0xff, 0xff, 0xff, 0xff}};
  for (auto at = kHeaderSize; at + 2 <= datagram.size(); at += 2)
    for (const auto& octets : kTwo) try_at(at, octets);
  for (auto at = kHeaderSize; at + 4 <= datagram.size(); at += 4)
    for (const auto& octets : kFour) try_at(at, octets);
}

bool is_announcement(BytesView datagram) {
  auto reader = MessageReader::open(datagram);
  while (reader) {
    const auto view = reader->next();
    if (!view || !*view) return false;
    if ((*view)->id != SubmessageId::data) continue;
    const auto data = read_data(**view);
    if (data && data->writer == kSpdpWriter) return true;
  }
  return false;
}

// Sends the broken forms of a message before it, except for repeated messages.
class Breaker {
 public:
  Breaker(Pair& pair, bool is_discovery_open) : pair_(pair), is_discovery_open_(is_discovery_open) {
    pair.world.filter = [this](const Node& from, Bytes datagram) {
      ears_.hear(datagram);
      if (!is_announcement(datagram) && known_[{from.port, datagram.size()}]++ < 3)
        break_up(from, datagram);
      return one(std::move(datagram));
    };
  }
  int forms() const { return forms_; }
  const Eavesdropper& ears() const { return ears_; }

 private:
  void break_up(const Node& from, const Bytes& datagram) {
    auto& to = &from == &pair_.a ? pair_.b : pair_.a;
    const auto matched = to.listener.matched;
    const Use use = [&](BytesView broken) {
      ++forms_;
      to->receive(broken, pair_.world.now);
    };
    each_truncation(datagram, use);
    each_extreme(datagram, use);
    // If only the second submessage is cut, the first one is still valid: the endpoints may match
    // and honest samples may arrive. Nothing more may happen, except where discovery is open and
    // anyone can announce endpoints.
    if (!is_discovery_open_) {
      EXPECT_GE(to.listener.matched, matched);
    }
    EXPECT_LE(to->remote_participants().size(), 1u);
    for (const auto& change : to.listener.changes) {
      EXPECT_TRUE(change.is_alive());
      EXPECT_TRUE(std::ranges::equal(change.payload.view(), payload().view()));
    }
    to.events.all.clear();
  }

  Pair& pair_;
  const bool is_discovery_open_;
  Eavesdropper ears_;
  std::map<std::pair<std::uint32_t, std::size_t>, int> known_;
  int forms_ = 0;
};

class BrokenMessages : public ::testing::TestWithParam<Rules> {};

TEST_P(BrokenMessages, EveryBrokenForm_ChangesNothing) {
  Pair pair(GetParam());
  const bool is_discovery_open = !is_protected(GetParam().discovery);
  Breaker breaker(pair, is_discovery_open);
  ASSERT_TRUE(pair.world.run_until([&] { return know_each_other(pair); }, 300));
  for (const auto* kind : {"+Req", "+Reply", "+Final"})
    EXPECT_NE(breaker.ears().heard(kind), nullptr);
  if (is_discovery_open) {
    pair.world.run(100);
    EXPECT_TRUE(know_each_other(pair));
  } else {
    ASSERT_TRUE(pair.match());
    pair.write();
    EXPECT_TRUE(pair.world.run_until([&] { return pair.b.listener.changes.size() == 1; }, 300));
    pair.world.run(50);
    EXPECT_EQ(pair.b.listener.changes.size(), 1u);
  }
  EXPECT_GT(breaker.forms(), 100'000);
  RecordProperty("forms", breaker.forms());
}

INSTANTIATE_TEST_SUITE_P(
    Protection, BrokenMessages,
    ::testing::Values(everything(kSign), everything(kEncryptOa),
                      Rules{.discovery = kEncrypt, .metadata = kEncrypt, .data = kEncrypt},
                      Rules{.data = kEncrypt}));

// Without security, no submessage is protected, also not one of a source whose prefix is zero.
TEST(MessageWithoutASource, ToParticipantsWithoutSecurity_ChangesNothing) {
  World world;
  Node a(1), b(2);
  world.nodes = {&a, &b};
  auto qos = default_reader_qos();
  qos.reliability.kind = ReliabilityKind::reliable;
  const auto writer = *a->create_writer(square(default_writer_qos()), a.listener, world.now);
  const auto reader = *b->create_reader(square(qos), b.listener, world.now);
  ASSERT_TRUE(world.run_until([&] { return a.listener.matched + b.listener.matched == 2; }, 300));
  const std::pair<EntityId, EntityId> addressed[] = {{reader.entity, writer.entity},
                                                     {kEntityIdUnknown, writer.entity},
                                                     {kPublicationsReader, kPublicationsWriter}};
  for (const auto& [asking, asked] : addressed)
    for (auto* node : {&a, &b}) {
      const auto send = [&](const auto& submessage) {
        (*node)->receive(forged(GuidPrefix{}, submessage), world.now,
                         *Locator::parse("127.0.0.1", 7999));
      };
      send(AckNack{asking, asked, SequenceNumberSet(SequenceNumber{1}), 1000, true});
      send(NackFrag{asking, asked, {1}, FragmentNumberSet(FragmentNumber{1}), 1000});
      send(Heartbeat{asking, asked, {1}, {1000}, 1000});
      send(Gap{asking, asked, {1}, SequenceNumberSet(SequenceNumber{1000})});
    }
  Change change;
  change.payload = payload();
  a->local_endpoints().writer(writer)->write(std::move(change), world.now);
  EXPECT_TRUE(world.run_until([&] { return b.listener.changes.size() == 1; }, 300));
}

}  // namespace
}  // namespace ddssec::rtps
