// A token in the form of SPDP and the handshake is read or refused. What was read is written alike.
#include <cstdlib>

#include "plugins/spi/token.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace ddssec;
  for (auto endian : {Endian::big, Endian::little}) {
    Reader reader({data, size}, endian);
    const auto token = spi::read_token(reader);
    if (!token) continue;
    Writer writer(endian);
    spi::write_token(writer, *token);
    const auto octets = writer.take();
    Reader again(octets, endian);
    const auto copy = spi::read_token(again);
    if (!copy || *copy != *token) std::abort();
  }
  return 0;
}
