// The private key file is read or refused without a question to the user. What was read is written
// and read.
#include <cstdlib>

#include "pki/private_key.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ddssec;
  const auto key = pki::PrivateKey::from_pem(BytesView(data, size));
  if (!key) return 0;
  const auto pem = key->to_pem();
  if (!pem) std::abort();
  const auto again = pki::PrivateKey::from_pem(*pem);
  if (!again || again->algorithm() != key->algorithm()) std::abort();
  return 0;
}
