// Revised keys of a hostile peer: the tokens of an authenticated peer with changes to them. A
// refused token changes nothing, and the honest revision still succeeds. A token that is accepted
// as a later revision leaves messages on their way readable.
#include <cstdlib>

#include "plugins/cryptography/key_revision.hpp"
#include "tests/unit/cryptography/two_sides.hpp"

namespace {

using namespace ddssec;
using namespace ddssec::cryptography;
using namespace ddssec::cryptography::testing;

constexpr auto kEncrypt = ProtectionKind::encrypt_with_origin_authentication;

// In this scene `a` is revising its keys.
struct Revision {
  Revision()
      : two(participant_attributes(kEncrypt, true)),
        ends(two.endpoints(endpoint_attributes(kEncrypt, ProtectionKind::encrypt))) {
    former = sent(), late = sent();
    number = two.a.factory().revise_local_entity_keys(two.a.participant).value();
    of_participant = two.participant_tokens(KeyStage::revised).value();
    of_writer = two.writer_tokens(ends, KeyStage::revised).value();
  }
  struct Sent {
    Bytes message, submessage, payload;
  };
  Sent sent() {
    return {encode_message(two, rtps_message({data_submessage(16)})).value(),
            encode_submessage(two, ends, data_submessage(16)).value(),
            encode_payload(two, ends, Bytes(16, 3)).value()};
  }
  void must_read_message(const Sent& sent) {
    if (!decode_message(two, sent.message)) std::abort();
  }
  void must_read_data(const Sent& sent) {
    if (!decode_submessage(two, ends, sent.submessage) || !decode_payload(two, ends, sent.payload))
      std::abort();
  }
  void activate() {
    if (!two.a.factory().activate_key_revision(two.a.participant, number)) std::abort();
  }

  TwoSides two;
  WriterToReader ends;
  Sent former, late;  // each message counts once
  KeyRevision number = 0;
  Tokens of_participant, of_writer;
};

// Returns the tokens with `change` applied to the key material of each.
Tokens changed(Tokens tokens, BytesView change) {
  for (auto& token : tokens) {
    auto& octets = token.binary_properties.front().value;
    for (std::size_t i = 0; i < std::min(octets.size(), change.size()); ++i) octets[i] ^= change[i];
  }
  return tokens;
}

// True if they are a later revision of the honest keys: neither the same revision again, nor other
// keys.
bool is_revision_of(const Tokens& tokens, const Tokens& honest) {
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const auto made = read_crypto_token(tokens[i]), of = read_crypto_token(honest[i]);
    if (!made || made->sender_key_id != of->sender_key_id ||
        made->kind.octets[3] != of->kind.octets[3] || revision_of(made->kind) == 0)
      return false;
  }
  return true;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const BytesView change(data, size);
  Revision it;
  const auto bad_participant = changed(it.of_participant, change);
  const auto bad_writer = changed(it.of_writer, change);
  const bool took_participant = it.two.take_participant(bad_participant).has_value();
  const bool took_writer = it.two.take_writer(it.ends, bad_writer).has_value();
  if (!took_participant || is_revision_of(bad_participant, it.of_participant))
    it.must_read_message(it.former);
  if (!took_writer || is_revision_of(bad_writer, it.of_writer)) it.must_read_data(it.former);
  if (took_participant || took_writer) return 0;
  if (!it.two.take_participant(it.of_participant) || !it.two.take_writer(it.ends, it.of_writer))
    std::abort();
  it.activate();
  for (const auto& sent : {it.late, it.sent()}) {
    it.must_read_message(sent);
    it.must_read_data(sent);
  }
  return 0;
}
