// Handshake messages in fragments, as Cyclone DDS sends them, between forged ones in the peer's
// name.
#include <random>

#include "tests/unit/rtps_security/attacker.hpp"

namespace ddssec::rtps {
namespace {

using namespace testing;

constexpr std::uint16_t kFragmentSize = 1344;

// A handshake message in the form of Cyclone DDS: each fragment is in a message of its own.
struct Fragments {
  GuidPrefix from;
  std::int64_t number = 0;
  Bytes whole;

  std::uint32_t count() const {
    return DataFrag::fragments_of(static_cast<std::uint32_t>(whole.size()), kFragmentSize);
  }
  Bytes datagram(std::uint32_t index, const Bytes& content) const {
    const auto begin = std::size_t{index} * kFragmentSize;
    const auto octets = BytesView(content).subspan(begin);
    return forged(
        from,
        DataFrag{.reader = kStatelessMessageReader,
                 .writer = kStatelessMessageWriter,
                 .sequence_number = {number},
                 .first = {index + 1},
                 .fragment_size = kFragmentSize,
                 .sample_size = static_cast<std::uint32_t>(content.size()),
                 .payload = octets.first(std::min<std::size_t>(kFragmentSize, octets.size()))});
  }
};

// Returns the fragments of a datagram with a handshake message that must be cut.
std::optional<Fragments> fragments_of(BytesView datagram) {
  auto reader = MessageReader::open(datagram);
  while (reader) {
    const auto view = reader->next();
    if (!view || !*view) return std::nullopt;
    if ((*view)->id != SubmessageId::data) continue;
    const auto data = read_data(**view);
    if (!data || data->writer != kStatelessMessageWriter) continue;
    if (data->payload.size() <= kFragmentSize) return std::nullopt;
    return Fragments{reader->header().prefix, data->sequence_number.value, to_bytes(data->payload)};
  }
  return std::nullopt;
}

// Everything is sent in fragments. The attacker hears them, and adds others in the same name.
class Forger {
 public:
  // `between` is the largest number of forgeries between two honest fragments, and `per_step` the
  // number of further ones.
  Forger(Pair& pair, int between, int per_step, std::uint32_t seed)
      : between_(between), per_step_(per_step), random_(seed) {
    pair.world.attack = [this](World::Traffic& traffic) { change(traffic); };
  }
  int honest = 0, forgeries = 0;

 private:
  // The port, and the message that is sent to it.
  using Victim = std::pair<std::uint32_t, Fragments>;

  void change(World::Traffic& traffic) {
    World::Traffic out;
    for (auto& [port, datagram] : traffic) {
      if (random_() % 2 == 0) flood(out, per_step_ / 4);
      const auto message = fragments_of(datagram);
      if (!message) {
        out.emplace_back(port, std::move(datagram));
        continue;
      }
      remember({port, *message});
      for (std::uint32_t i = 0; i < message->count(); ++i) {
        for (auto n = between_ > 0 ? random_() % static_cast<unsigned>(between_ + 1) : 0; n > 0;
             --n)
          out.push_back(forgery(heard_.back()));
        out.emplace_back(port, message->datagram(i, message->whole));
        ++honest;
      }
    }
    flood(out, per_step_);
    traffic = std::move(out);
  }
  void remember(Victim victim) {
    if (heard_.size() > 3) heard_.erase(heard_.begin());
    heard_.push_back(std::move(victim));
  }
  void flood(World::Traffic& out, int count) {
    for (int i = 0; i < count && !heard_.empty(); ++i)
      out.push_back(forgery(heard_[random_() % heard_.size()]));
  }
  // Returns one fragment with an octet changed, of this message, or of the next one before it is
  // sent.
  std::pair<std::uint32_t, Bytes> forgery(const Victim& victim) {
    ++forgeries;
    auto [port, message] = victim;
    if (random_() % 4 == 0) ++message.number;
    const auto index = static_cast<std::uint32_t>(random_() % message.count());
    auto content = message.whole;
    const auto begin = std::size_t{index} * kFragmentSize;
    const auto size = std::min<std::size_t>(kFragmentSize, content.size() - begin);
    content[begin + random_() % size] ^= static_cast<std::uint8_t>(1 + random_() % 255);
    return {port, message.datagram(index, content)};
  }

  const int between_, per_step_;
  std::mt19937 random_;
  std::vector<Victim> heard_;
};

// Returns how long it took; nothing if it never happened.
std::optional<MonotonicTime> joined_after(int between, int per_step, std::uint32_t seed) {
  Pair pair({});
  Forger forger(pair, between, per_step, seed);
  const auto begin = pair.world.now;
  const bool joined = pair.world.run_until([&] { return know_each_other(pair); }, 1000);
  EXPECT_GT(forger.honest, 4);
  EXPECT_EQ(forger.forgeries > 0, between + per_step > 0);
  return joined ? std::optional(pair.world.now - begin) : std::nullopt;
}

TEST(Fragments, FragmentsOfAHandshake_ArePutTogether) {
  const auto took = joined_after(0, 0, 1);
  ASSERT_TRUE(took);
  EXPECT_LT(*took, 200ms);
}

// The attacker reacts to each honest fragment before the next one arrives.
TEST(Fragments, ForgedOnesBetweenTheHonest_DoNotKeepThePeerOut) {
  for (std::uint32_t seed = 1; seed <= 5; ++seed) {
    const auto took = joined_after(2, 0, seed);
    ASSERT_TRUE(took) << seed;
    EXPECT_LT(*took, seconds(2)) << seed;
  }
}

// The attacker sends 10,000 forgeries a second.
TEST(Fragments, AFloodOfForgedOnes_DoesNotKeepThePeerOut) {
  for (std::uint32_t seed = 1; seed <= 3; ++seed) {
    const auto took = joined_after(1, 100, seed);
    ASSERT_TRUE(took) << seed;
    EXPECT_LT(*took, seconds(2)) << seed;
  }
}

}  // namespace
}  // namespace ddssec::rtps
