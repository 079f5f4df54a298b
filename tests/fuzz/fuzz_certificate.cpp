// A peer's c.id, a CA file and a revocation list are parsed or refused. What was parsed parses
// again.
#include <cstdlib>

#include "pki/certificate.hpp"
#include "pki/crl.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ddssec;
  const BytesView octets(data, size);
  for (const auto& certificate :
       {pki::Certificate::from_pem(octets), pki::Certificate::from_der(octets)}) {
    if (!certificate) continue;
    const auto again = pki::Certificate::from_pem(as_bytes(certificate->pem()));
    if (!again || !(*again == *certificate)) std::abort();
  }
  (void)pki::Certificate::bundle_from_pem(octets);
  (void)pki::Crl::all_from(octets);
  return 0;
}
