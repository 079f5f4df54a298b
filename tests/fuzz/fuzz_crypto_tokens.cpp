// Crypto tokens of an authenticated peer gone bad. A refused token changes nothing: the honest
// peer's samples still open. One that is taken replaces the key, and the honest one can come back.
#include <array>
#include <cstdlib>

#include "tests/unit/cryptography/two_sides.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::cryptography;
using namespace ddssec::cryptography::testing;
using Tokens = std::vector<spi::Token>;

struct Pair {
  explicit Pair(ProtectionKind kind)
      : two(kind),
        ends(two.endpoints(endpoint_attributes(kind, ProtectionKind::encrypt))),
        message(encode_message(two, rtps_message({data_submessage(16)})).value()),
        submessage(encode_submessage(two, ends, data_submessage(16)).value()),
        reply(encode_reply(two, ends, data_submessage(16, 0x06)).value()),
        of_participant(two.a.exchange()
                           .create_local_participant_crypto_tokens(two.a.participant, two.a.remote)
                           .value()),
        of_writer(two.a.exchange()
                      .create_local_datawriter_crypto_tokens(ends.writer, ends.remote_reader)
                      .value()),
        of_reader(two.b.exchange()
                      .create_local_datareader_crypto_tokens(ends.reader, ends.remote_writer)
                      .value()) {}

  bool set_participant(const Tokens& tokens) {
    return two.b.exchange()
        .set_remote_participant_crypto_tokens(two.b.participant, two.b.remote, tokens)
        .has_value();
  }
  bool set_writer(const Tokens& tokens) {
    return two.b.exchange()
        .set_remote_datawriter_crypto_tokens(ends.reader, ends.remote_writer, tokens)
        .has_value();
  }
  bool set_reader(const Tokens& tokens) {
    return two.a.exchange()
        .set_remote_datareader_crypto_tokens(ends.writer, ends.remote_reader, tokens)
        .has_value();
  }

  void attack(const Tokens& tokens) {
    if (set_participant(tokens) && !set_participant(of_participant)) std::abort();
    if (set_writer(tokens) && !set_writer(of_writer)) std::abort();
    if (set_reader(tokens) && !set_reader(of_reader)) std::abort();
    if (!decode_message(two, message) || !decode_submessage(two, ends, submessage) ||
        !decode_reply(two, ends, reply))
      std::abort();
  }

  TwoSides two;
  WriterToReader ends;
  Bytes message, submessage, reply;
  Tokens of_participant, of_writer, of_reader;
};

spi::Token token_of(Bytes key_material) {
  return {.class_id = "DDS:Crypto:AES_GCM_GMAC",
          .binary_properties = {{"dds.cryp.keymat", std::move(key_material), true}}};
}

/// All octets as one token's key material, halved into two tokens', and as tokens of any form.
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
