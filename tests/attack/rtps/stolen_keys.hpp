// What a participant forges with keys that it was given.
#pragma once

#include "tests/unit/cryptography/insider.hpp"
#include "tests/unit/rtps_security/attacker.hpp"
#include "tests/unit/rtps_security/trio.hpp"

namespace ddssec::rtps::testing {

/// Sends bob a submessage in alice's name, under each of the keys. He opens it by the one that
/// fits.
template <class S>
void forge(Trio& trio, const KeyThief::Tokens& keys, const S& submessage) {
  const auto& prefix = trio.a->prefix();
  const auto whole = forged(prefix, submessage);
  const Bytes content(whole.begin() + kHeaderSize, whole.end());
  for (const auto& token : keys) {
    auto material = cryptography::read_crypto_token(token);
    if (!material || material->is_none()) continue;
    cryptography::testing::Insider insider(std::move(*material));
    auto datagram = forged(prefix);
    const auto group = insider.group(cryptography::kSubmessageFrame, content);
    datagram.insert(datagram.end(), group.begin(), group.end());
    trio.b->receive(datagram, trio.world.now, *Locator::parse("127.0.0.9", 0));
  }
}

}  // namespace ddssec::rtps::testing
