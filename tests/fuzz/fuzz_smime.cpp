// A signed document and a CA that signed nothing: the document must never verify.
#include <cstdlib>

#include "pki/authority.hpp"
#include "pki/smime.hpp"

namespace {

const ddssec::WallTime kNow{std::chrono::seconds(1'800'000'000)};

ddssec::pki::DocumentVerifier make_verifier() {
  using namespace ddssec;
  SystemRandom random;
  const auto ca = pki::Authority::create(
      "CN=nobody", {}, {kNow - std::chrono::hours(1), kNow + std::chrono::hours(1)}, random);
  return pki::DocumentVerifier::make({ca->certificate()}).value();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const auto verifier = make_verifier();
  if (verifier.verify({data, size}, kNow)) std::abort();
  return 0;
}
