// A peer's ephemeral public key of every kind is refused, or a secret can be derived from it.
#include <array>
#include <cstdlib>

#include "pki/key_agreement.hpp"

namespace {

using namespace ddssec;
using enum pki::KeyAgreementKind;
constexpr std::array kKinds = {ecdh_p256, ecdh_p384, dh_modp_2048_256};

const pki::EphemeralKey& own_key(std::size_t kind) {
  static const std::array keys = {pki::EphemeralKey::generate(kKinds[0]).value(),
                                  pki::EphemeralKey::generate(kKinds[1]).value(),
                                  pki::EphemeralKey::generate(kKinds[2]).value()};
  return keys[kind];
}

}  // namespace

// The first octet chooses the kind.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::size_t kind = data[0] % kKinds.size();
  const BytesView octets(data + 1, size - 1);
  const auto key = pki::PeerPublicKey::parse(kKinds[kind], octets);
  if (!key) return 0;
  if (key->kind() != kKinds[kind] || !own_key(kind).derive(*key)) std::abort();
  for (std::size_t other = 0; other < kKinds.size(); ++other)
    if (other != kind && own_key(other).derive(*key)) std::abort();
  return 0;
}
