// Crypto tokens of a hostile authenticated peer. A refused token changes nothing, so the honest
// peer's samples still open. An accepted token replaces the key, and the honest peer can come back.
#include <array>
#include <cstdlib>

#include "tests/unit/cryptography/two_sides.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::cryptography;
using namespace ddssec::cryptography::testing;

struct Pair {
  explicit Pair(ProtectionKind kind)
      : two(kind),
        ends(two.endpoints(endpoint_attributes(kind, ProtectionKind::encrypt))),
        of_participant(two.participant_tokens().value()),
        of_writer(two.writer_tokens(ends).value()),
        of_reader(two.reader_tokens(ends).value()) {}

  void attack(const Tokens& tokens) {
    if (two.take_participant(tokens) && !two.take_participant(of_participant)) std::abort();
    if (two.take_writer(ends, tokens) && !two.take_writer(ends, of_writer)) std::abort();
    if (two.take_reader(ends, tokens) && !two.take_reader(ends, of_reader)) std::abort();
    const auto message = encode_message(two, rtps_message({data_submessage(16)})).value();
    const auto submessage = encode_submessage(two, ends, data_submessage(16)).value();
    const auto reply = encode_reply(two, ends, data_submessage(16, 0x06)).value();
    if (!decode_message(two, message) || !decode_submessage(two, ends, submessage) ||
        !decode_reply(two, ends, reply))
      std::abort();
  }

  TwoSides two;
  WriterToReader ends;
  // They are made before all messages, because older ones are refused.
  Tokens of_participant, of_writer, of_reader;
};

spi::Token token_of(Bytes key_material) {
  return {.class_id = "DDS:Crypto:AES_GCM_GMAC",
          .binary_properties = {{"dds.cryp.keymat", std::move(key_material), true}}};
}

// Returns all octets as the key material of one token, halved into that of two tokens, and as
// tokens of any form.
std::array<Tokens, 3> tokens_in(BytesView octets) {
  std::array<Tokens, 3> out;
  out[0] = {token_of(to_bytes(octets))};
  const auto half = octets.size() / 2;
  out[1] = {token_of(to_bytes(octets.first(half))), token_of(to_bytes(octets.subspan(half)))};
  Reader reader(octets, Endian::little);
  for (auto token = spi::read_token(reader); token && out[2].size() < 3;
       token = spi::read_token(reader))
    out[2].push_back(*token);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static std::array<Pair, 2> pairs = {Pair(ProtectionKind::encrypt),
                                      Pair(ProtectionKind::encrypt_with_origin_authentication)};
  for (const auto& tokens : tokens_in({data, size}))
    for (auto& pair : pairs) pair.attack(tokens);
  return 0;
}
