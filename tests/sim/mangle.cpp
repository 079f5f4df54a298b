#include "tests/sim/mangle.hpp"

namespace ddssec::rtps::sim {
namespace {

// Numbers at which code tends to break.
constexpr std::array<std::uint32_t, 10> kWords = {
    0, 1, 2, 0xff, 0xffff, 0x10000, 0x7fffffff, 0x80000000, 0xfffffffe, 0xffffffff};

void mangle_word(Bytes& octets, Dice& dice) {
  if (octets.size() < 4) return;
  const auto at = dice.below(octets.size() / 4) * 4;
  const auto word = dice.of(kWords);
  const bool little = dice.chance(700);
  for (std::size_t i = 0; i < 4; ++i)
    octets[at + i] = static_cast<std::uint8_t>(word >> 8 * (little ? i : 3 - i));
}

// Replaces one of the names in the octets by another.
void rename(Bytes& octets, Dice& dice, std::span<const GuidPrefix> names) {
  if (names.empty()) return;
  const auto first = dice.below(names.size());
  const auto to = dice.of(names);
  for (std::size_t i = 0; i < names.size(); ++i)
    if (const auto& from = names[(first + i) % names.size()];
        from != to && exchange(octets, from.view(), to.view()))
      return;
}

void mangle_once(Bytes& octets, Dice& dice, std::span<const GuidPrefix> names) {
  if (octets.empty()) return;
  switch (dice.below(6)) {
    case 0:
      octets[dice.below(octets.size())] ^= static_cast<std::uint8_t>(1u << dice.below(8));
      return;
    case 1:
      octets[dice.below(octets.size())] = dice.octet();
      return;
    case 2:
    case 3:
      return mangle_word(octets, dice);
    case 4:
      return rename(octets, dice, names);
    default:
      exchange(octets, as_bytes(dice.of(kTopics)), as_bytes(dice.of(kTopics)));
  }
}

}  // namespace

bool exchange(Bytes& octets, BytesView from, BytesView to) {
  bool any = false;
  for (auto at = octets.begin();;) {
    const auto found = std::search(at, octets.end(), from.begin(), from.end());
    if (found == octets.end()) return any;
    at = std::copy(to.begin(), to.end(), found);
    any = true;
  }
}

void mangle(Bytes& octets, Dice& dice, std::span<const GuidPrefix> names) {
  for (auto changes = 1 + dice.below(3); changes > 0; --changes) mangle_once(octets, dice, names);
}

}  // namespace ddssec::rtps::sim
