// How much a participant sends to others for what a stranger sends to it (T60).
#include "tests/unit/rtps_security/attacker.hpp"
#include "wire/acknack.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

/// Octets that `node` sends to ports of the victim meanwhile.
std::size_t sent_to_victim(World& world, Node& node, int steps) {
  std::size_t out = 0;
  for (int i = 0; i < steps; ++i) {
    for (const auto& [port, octets] : node.post.sent)
      out += port >= 7990 && port < 8000 ? octets.size() : 0;
    world.run(1);
  }
  return out;
}

// It names four addresses of the victim, and never says a word. Before: 464 times its octets.
TEST(Amplification, OfOneAnnouncement_IsBounded) {
  Pair pair({});
  pair.world.nodes = {&pair.a};
  pair.world.run(1);
  auto data = secured_data(fake_prefix(1));
  data.guid.prefix.octets.fill(0xff);  // we begin
  data.metatraffic_unicast.clear();
  for (std::uint16_t port = 7990; port < 7994; ++port)
    data.metatraffic_unicast.push_back(*Locator::parse("192.0.2.1", port));
  const auto datagram = announcement(data);
  pair.a->receive(datagram, pair.world.now, *Locator::parse("192.0.2.66", 7410));
  const auto out = sent_to_victim(pair.world, pair.a, 12'000);
  EXPECT_GT(out, 0u);
  EXPECT_LT(out, 40 * datagram.size());
  RecordProperty("ratio", static_cast<int>(out / datagram.size()));
}

// In the name of a reader, where nothing is protected. Before: 338 times their octets.
TEST(Amplification, OfManyRequestsInOneDatagram_IsBounded) {
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
