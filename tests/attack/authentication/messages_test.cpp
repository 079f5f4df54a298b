// Attacks on the handshake: T9 (downgrade), T12 (GUID of another participant), T23 to T26 (lengths)
// and T48 (invalid keys) in docs/attacks.md.
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

// ---- T9: whatever is changed on the way, one side notices before a secret is used

TEST(Downgrade, ChangedAlgorithmInTheRequest_IsNoticed) {
  for (const bool hide : {false, true}) {
    Pairing pairing;
    auto& two = pairing.two;
    const auto request = two.request();
    Token changed = with(*request->message, "c.kagree_algo", bytes("DH+MODP-2048-256"));
    const auto weak = pki::EphemeralKey::generate(pki::KeyAgreementKind::dh_modp_2048_256).value();
    changed = with(changed, "dh1", *weak.public_octets());
    if (hide) changed = without(changed, "hash_c1");
    const auto reply = two.reply(changed);
    if (!hide) {
      EXPECT_CODE(reply, token_field_differs);
      continue;
    }
    ASSERT_OK(reply);
    EXPECT_CODE(two.process_at_lower_guid(request->handle, *reply->message),
                key_agreement_algorithm_changed);
    Token patched = with(*reply->message, "c.kagree_algo", bytes("ECDH+prime256v1-CEUM"));
    patched = with(patched, "dh1", field(*request->message, "dh1"));
    patched = with(patched, "hash_c1", field(*request->message, "hash_c1"));
    EXPECT_CODE(two.process_at_lower_guid(request->handle, without(patched, "hash_c2")),
                public_key_malformed);
  }
}

TEST(Downgrade, ChangedSignatureName_IsNoticed) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto request = two.request();
  const Token changed =
      without(with(*request->message, "c.dsign_algo", bytes("RSASSA-PSS-SHA256")), "hash_c1");
  const auto reply = two.reply(changed);
  ASSERT_OK(reply);
  EXPECT_CODE(two.process_at_lower_guid(request->handle, *reply->message), token_field_differs);
  EXPECT_CODE(two.process_at_lower_guid(request->handle, without(*reply->message, "hash_c1")),
              signature_invalid);
}

TEST(Downgrade, ChangedPermissions_AreNoticed) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto request = two.request();
  const Token changed = without(with(*request->message, "c.perm", bytes("other")), "hash_c1");
  const auto reply = two.reply(changed);
  ASSERT_OK(reply);
  EXPECT_CODE(two.process_at_lower_guid(request->handle, without(*reply->message, "hash_c1")),
              signature_invalid);
}

TEST(Downgrade, ChangedParticipantData_IsNoticed) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto request = two.request();
  Bytes data = field(*request->message, "c.pdata");
  data[4] ^= 1;  // the protocol version; security masks are in the same list
  const Token changed = without(with(*request->message, "c.pdata", data), "hash_c1");
  const auto reply = two.reply(changed);
  ASSERT_OK(reply);
  EXPECT_CODE(two.process_at_lower_guid(request->handle, without(*reply->message, "hash_c1")),
              signature_invalid);
}

// ---- T12: the GUID of another participant

TEST(ForeignGuid, AMember_CannotTakeAnothersGuid) {
  TestPlugin plugin;
  Participant us(plugin, make_identity(test_ca(), "CN=ours", {}, kYear, 1), 1);
  const auto mallory = make_identity(test_ca(), "CN=mallory");
  const auto victim = make_identity(test_ca(), "CN=victim", {}, kYear, 2);
  // The GUID is as low as possible, so that the attacker begins.
  Guid guid = adjusted_guid(victim.certificate.subject_digest(), candidate(3));
  guid.prefix.octets[0] = 0x80;
  guid.prefix.octets[1] = 0;
  const auto remote =
      plugin->validate_remote_identity(us.handle, {}, {"DDS:Auth:PKI-DH:1.0"}, guid);
  ASSERT_OK(remote);
  HandMadePeer peer(mallory, 3);
  Token request = peer.request(pki::KeyAgreementKind::ecdh_p256, {});
  EXPECT_CODE(plugin->begin_handshake_reply(request, remote->handle, us.handle, us.data),
              participant_guid_differs);
  request = without(with(request, "c.pdata", participant_data(guid)), "hash_c1");
  EXPECT_CODE(plugin->begin_handshake_reply(request, remote->handle, us.handle, us.data),
              guid_not_bound_to_subject);
  request = with(request, "c.id", bytes(victim.certificate.pem()));
  EXPECT_CODE(plugin->begin_handshake_reply(request, remote->handle, us.handle, us.data),
              guid_not_bound_to_subject);
}

// ---- T23 to T26: every length field of every token is set to the values that attackers use

void put(Bytes& octets, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) octets[at + i] = static_cast<std::uint8_t>(value >> (8 * i));
}

TEST(HandshakeLengths, Lies_AreRefusedBeforeAnythingIsAllocatedOrStored) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto request = two.request();
  Writer writer(Endian::little);
  spi::write_token(writer, *request->message);
  const Bytes honest = to_bytes(writer.view());
  for (std::size_t at = 0; at + 4 <= honest.size(); at += 4) {
    for (const std::uint32_t lie : {0u, 1u, 0x7fffffffu, 0x80000000u, 0xffffffffu, 0xfffffffcu}) {
      Bytes changed = honest;
      put(changed, at, lie);
      Reader reader(changed, Endian::little);
      const auto token = spi::read_token(reader);
      if (!token) continue;
      if (!two.reply(*token)) continue;
      // Only the fields that a request may choose or leave out may differ.
      for (const auto* name : {"c.id", "c.perm", "c.pdata", "c.dsign_algo", "c.kagree_algo", "dh1"})
        EXPECT_EQ(field(*token, name), field(*request->message, name)) << at;
      two.high.plugin->clock.advance(kPendingAge);
    }
  }
  const auto reply = two.reply(*request->message);
  ASSERT_OK(reply);
  pairing.expect_finish(*request, *reply);
}

// ---- T48: invalid keys

struct BadKey {
  std::string name;
  pki::KeyAgreementKind kind;
  Bytes octets;
};

Bytes modp(std::uint8_t last) {
  Bytes number(256);
  number.back() = last;
  return number;
}

std::vector<BadKey> bad_keys() {
  using enum pki::KeyAgreementKind;
  Bytes compressed(33, 5);
  compressed[0] = 2;
  Bytes zero_point(65);
  zero_point[0] = 4;
  return {{"Infinity", ecdh_p256, {0}},
          {"Compressed", ecdh_p256, compressed},
          {"ZeroPoint", ecdh_p256, zero_point},
          {"ShortPoint", ecdh_p256, Bytes(64, 4)},
          {"PointOfP384", ecdh_p256, Bytes(97, 4)},
          {"Zero", dh_modp_2048_256, modp(0)},
          {"One", dh_modp_2048_256, modp(1)},
          {"Two", dh_modp_2048_256, modp(2)},  // is not in the subgroup of order q
          {"AllOnes", dh_modp_2048_256, Bytes(256, 0xff)},
          {"TooLong", dh_modp_2048_256, Bytes(300, 1)}};
}

class InvalidKey : public testing::TestWithParam<BadKey> {};
INSTANTIATE_TEST_SUITE_P(T48, InvalidKey, testing::ValuesIn(bad_keys()),
                         [](const auto& info) { return info.param.name; });

TEST_P(InvalidKey, RequestWithAnInvalidKey_IsRefused) {
  Pairing pairing;
  auto& two = pairing.two;
  const auto request = two.request();
  Token changed = without(with(*request->message, "dh1", GetParam().octets), "hash_c1");
  if (GetParam().kind == pki::KeyAgreementKind::dh_modp_2048_256)
    changed = with(changed, "c.kagree_algo", bytes("DH+MODP-2048-256"));
  const auto reply = two.reply(changed);
  ASSERT_FALSE(reply);
  EXPECT_TRUE(reply.error().code() == Code::public_key_malformed ||
              reply.error().code() == Code::public_key_not_in_group)
      << reply.error().to_sentence();
}

}  // namespace
}  // namespace ddssec::authentication
