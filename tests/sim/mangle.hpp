// Changes that attackers make to octets, whatever these mean.
#pragma once

#include <span>

#include "tests/sim/cast.hpp"
#include "tests/sim/dice.hpp"

namespace ddssec::rtps::sim {

/// Makes one to three changes in place: a bit, an octet, an aligned word, a name for another name,
/// a topic for another topic. The length stays.
void mangle(Bytes& octets, Dice& dice, std::span<const GuidPrefix> names);
/// Replaces each occurrence of `from` by `to`, which is as long.
bool exchange(Bytes& octets, BytesView from, BytesView to);

}  // namespace ddssec::rtps::sim
