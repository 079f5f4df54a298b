// After two participants have exchanged their keys through the C ABI, talked and gone, none of
// their secrets is left in memory. Tokens and shared secrets cross the ABI in the host's memory.
#include "tests/support/remains.hpp"

#include <gtest/gtest.h>

#include "tests/support/cyclone_driver.hpp"

namespace ddssec::driver {
namespace {

using test::Remains;
using KeyExchange = dds_security_crypto_key_exchange;

const std::string kPki = DDSSEC_DRIVER_PKI;
const std::string kOurs = DDSSEC_PLUGIN_DIR "/libddssec_";
const Paths kPaths = {kOurs + "authentication.so", kOurs + "access_control.so",
                      kOurs + "cryptography.so"};

// The functions of the plugin, and where watch() notes what passes through them.
KeyExchange original;
Remains* noted = nullptr;

// Notes KeyMaterial_AES_GCM_GMAC (DDS-Security 1.2, clause 10.5.2.1.2) with keys of 256 bits. The
// salt is secret, too.
void note(const DDS_Security_CryptoTokenSeq& tokens) {
  constexpr std::size_t kSalt = 8, kSenderKey = 48, kReceiverKey = 88, kSize = 32;
  for (unsigned i = 0; i < tokens._length; ++i) {
    const auto& properties = tokens._buffer[i].binary_properties;
    if (properties._length == 0) continue;
    const auto& octets = properties._buffer[0].value;
    const BytesView value(octets._buffer, octets._length);
    if (value.size() < kSenderKey + kSize) continue;
    noted->look_for("salt", value.subspan(kSalt, kSize));
    noted->look_for("sender key", value.subspan(kSenderKey, kSize));
    if (value.size() >= kReceiverKey + kSize)
      noted->look_for("receiver key", value.subspan(kReceiverKey, kSize));
  }
}

template <auto Set>
DDS_Security_boolean note_and_set(KeyExchange* exchange, DDS_Security_long_long local,
                                  DDS_Security_long_long remote,
                                  const DDS_Security_CryptoTokenSeq* tokens, Exception* ex) {
  note(*tokens);
  return (original.*Set)(exchange, local, remote, tokens, ex);
}

void watch(Domain& domain) {
  auto& exchange = *domain.cryptography().crypto_key_exchange;
  original = exchange;
  constexpr auto participant = &KeyExchange::set_remote_participant_crypto_tokens;
  constexpr auto writer = &KeyExchange::set_remote_datawriter_crypto_tokens;
  constexpr auto reader = &KeyExchange::set_remote_datareader_crypto_tokens;
  exchange.*participant = note_and_set<participant>;
  exchange.*writer = note_and_set<writer>;
  exchange.*reader = note_and_set<reader>;
}

void note_secret(const Peer& peer) {
  const auto* const layout = reinterpret_cast<const cyclonedds::SharedSecretLayout*>(peer.secret);
  noted->look_for("shared secret",
                  {layout->shared_secret, static_cast<std::size_t>(layout->shared_secret_size)});
}

[[gnu::noinline]] void live() {
  Domain one(kPaths), other(kPaths);
  for (auto* domain : {&one, &other}) watch(*domain);
  Participant a(one, kPki, "a", "origin"), b(other, kPki, "b", "origin");
  const Link link(a, b, "Square");
  note_secret(link.a_of_b);
  note_secret(link.b_of_a);
  const Octets plain(100, 7);
  EXPECT_EQ(link.receiver.decode_payload(link.sender.encode_payload(plain)).octets(), plain);
  EXPECT_FALSE(noted->find().empty()) << "they are found while they are in use";
}

TEST(CyclonesRemains, TwoParticipantsThatHaveLeft_LeaveNoSecretsOfTheirTokens) {
  Remains remains;
  noted = &remains;
  test::at_depth(live);
  // There are the shared secret of both sides, and the keys of the participant and of an endpoint
  // of each.
  EXPECT_GE(remains.size(), 12u);
  EXPECT_EQ(remains.find(), std::vector<std::string>());
}

}  // namespace
}  // namespace ddssec::driver
