// Discovery data of all three builtin types is read or refused. What was read is written and read
// alike.
#include <array>
#include <cstdlib>

#include "rtps/discovery/endpoint_data.hpp"
#include "rtps/discovery/participant_data.hpp"
#include "wire/span_writer.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::rtps;

void check(BytesView octets, auto read) {
  auto first = read(octets);
  if (!first) return;
  // This is read from Cyclone DDS's announcements, and never written.
  if constexpr (requires { first->vendor_version; }) first->vendor_version.clear();
  static std::array<std::uint8_t, 1 << 18> buffer;
  SpanWriter out(buffer);
  write_payload(out, *first);
  if (out.overflowed()) return;
  const auto again = read(out.view());
  if (!again || *again != *first) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  check({data, size}, read_participant_data);
  check({data, size}, read_publication_data);
  check({data, size}, read_subscription_data);
  return 0;
}
