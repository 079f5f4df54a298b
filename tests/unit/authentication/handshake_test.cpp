// Handshakes that must succeed: every kind of key, both roles, every vendor's style.
#include "tests/unit/authentication/authentication_fixture.hpp"

namespace ddssec::authentication {
namespace {

using pki::KeyAgreementKind;
using pki::PublicKeyEncoding;

constexpr KeySpec kSpecs[] = {
    {KeyKind::ec_p256}, {KeyKind::ec_p384}, {KeyKind::rsa, 2048}, {KeyKind::rsa, 3072}};

class KeysOfBoth : public testing::TestWithParam<std::tuple<KeySpec, KeySpec>> {};

INSTANTIATE_TEST_SUITE_P(Keys, KeysOfBoth,
                         testing::Combine(testing::ValuesIn(kSpecs), testing::ValuesIn(kSpecs)),
                         [](const auto& info) {
                           const auto name = [](KeySpec s) {
                             std::string text = to_string(pki::KeyAlgorithm{s.kind, s.bits});
                             std::erase(text, '-');
                             return text;
                           };
                           return name(std::get<0>(info.param)) + "_" +
                                  name(std::get<1>(info.param));
                         });

TEST_P(KeysOfBoth, EachPairOfKeys_Authenticates) {
  const auto [first, second] = GetParam();
  Pairing pairing(make_identity(test_ca(), "CN=alice", first),
                  make_identity(test_ca(), "CN=bob", second, kYear, 1));
  pairing.expect_success();
  EXPECT_TRUE(pairing.first_plugin.events.all.empty());
  EXPECT_TRUE(pairing.second_plugin.events.all.empty());
}

TEST(HandshakeTokens, Request_HasTheStandardsFieldsInOrderWithoutNuls) {
  Pairing pairing;
  const auto request = pairing.two.request();
  ASSERT_OK(request);
  EXPECT_EQ(request->message->class_id, "DDS:Auth:PKI-DH:1.0+Req");
  std::vector<std::string> names;
  for (const auto& p : request->message->binary_properties) names.push_back(p.name);
  EXPECT_EQ(names, (std::vector<std::string>{"c.id", "c.perm", "c.pdata", "c.dsign_algo",
                                             "c.kagree_algo", "hash_c1", "dh1", "challenge1"}));
  EXPECT_EQ(as_text(field(*request->message, "c.dsign_algo")), "ECDSA-SHA256");
  EXPECT_EQ(as_text(field(*request->message, "c.kagree_algo")), "ECDH+prime256v1-CEUM");
  EXPECT_EQ(field(*request->message, "dh1").size(), 65u);
  EXPECT_EQ(field(*request->message, "dh1")[0], 4);
  EXPECT_EQ(field(*request->message, "c.perm"), Bytes(1));
}

// ---- a peer that the test plays

// The plugin's participant has the higher GUID.
Identity ours(std::string_view = {}) { return make_identity(test_ca(), "CN=ours", {}, kYear, 1); }

// Returns an identity whose adjusted GUID is lower or higher than that of `ours`.
Identity theirs(bool below, KeySpec spec = {}) {
  const auto digest = ours().certificate.subject_digest();
  const Guid our_guid = adjusted_guid(digest, candidate(1));
  for (int i = 0;; ++i) {
    auto identity = make_identity(test_ca(), "CN=peer " + std::to_string(i), spec);
    const Guid guid = adjusted_guid(identity.certificate.subject_digest(), candidate(9));
    if ((guid < our_guid) == below) return identity;
  }
}

struct StyleCase {
  std::string name;
  Style style;
  KeyAgreementKind kind = KeyAgreementKind::ecdh_p256;
  PublicKeyEncoding encoding = PublicKeyEncoding::plain_integer;
  KeySpec spec = {};
};

const std::string kModp = "DH+MODP-2048-256";

const StyleCase kInitiators[] = {
    {"Standard", {}},
    {"Cyclone", {.optional_fields = false, .nul_terminated = true}},
    {"Fast", {.reversed = true, .key_agreement_name = kModp}, KeyAgreementKind::dh_modp_2048_256},
    {"FastRsa",
     {.signature_name = "RSASSA-PSS-SHA256", .key_agreement_name = kModp},
     KeyAgreementKind::dh_modp_2048_256,
     PublicKeyEncoding::plain_integer,
     {KeyKind::rsa, 2048}},
    {"FastEcLeafUnderRsaCa",
     {.signature_name = "RSASSA-PSS-SHA256", .key_agreement_name = kModp},
     KeyAgreementKind::dh_modp_2048_256},
    {"FastWithoutAccessControl",
     {.permissions = false, .key_agreement_name = kModp},
     KeyAgreementKind::dh_modp_2048_256},
    {"ModpDer",
     {.nul_terminated = true, .key_agreement_name = kModp},
     KeyAgreementKind::dh_modp_2048_256,
     PublicKeyEncoding::der_integer},
    {"Names12", {.signature_name = "ECDSA+P256+SHA256", .key_agreement_name = "ECDHE-CEUM+P256"}},
    {"Modp12", {.key_agreement_name = "DHE+MODP-2048-256"}, KeyAgreementKind::dh_modp_2048_256},
    {"P384", {.key_agreement_name = "ECDHE-CEUM+P384"}, KeyAgreementKind::ecdh_p384},
};

class InitiatorStyle : public testing::TestWithParam<StyleCase> {};

INSTANTIATE_TEST_SUITE_P(Styles, InitiatorStyle, testing::ValuesIn(kInitiators),
                         [](const auto& info) { return info.param.name; });

TEST_P(InitiatorStyle, RequestInEachStyle_GetsItsReply) {
  const auto& param = GetParam();
  TestPlugin plugin;
  Participant us(plugin, ours(), 1);
  HandMadePeer peer(theirs(true, param.spec), 9, param.style);
  const auto remote =
      plugin->validate_remote_identity(us.handle, {}, peer.identity_token(), peer.guid());
  ASSERT_OK(remote);
  EXPECT_EQ(remote->result, ValidationResult::pending_handshake_message);
  const auto request = peer.request(param.kind, param.encoding);
  const auto reply = plugin->begin_handshake_reply(request, remote->handle, us.handle, us.data);
  ASSERT_OK(reply);
  // Fast DDS compares the name octet for octet.
  EXPECT_EQ(as_text(field(*reply->message, "c.kagree_algo")), param.style.key_agreement_name);
  const auto& dh2 = field(*reply->message, "dh2");
  if (param.encoding == PublicKeyEncoding::der_integer) {
    EXPECT_EQ(dh2[0], 2);
  } else if (param.kind == KeyAgreementKind::dh_modp_2048_256) {
    EXPECT_LE(dh2.size(), 256u);
  }
  const auto final = peer.final(*reply->message, ours().certificate);
  const auto end = plugin->process_handshake(reply->handle, final);
  ASSERT_OK(end);
  EXPECT_EQ(end->result, ValidationResult::ok);
  const auto secret = plugin->shared_secret(reply->handle);
  ASSERT_OK(secret);
  peer.expect_same_secret(**secret);
  const auto credential = plugin->authenticated_peer_credential_token(reply->handle);
  ASSERT_OK(credential);
  EXPECT_EQ(as_text(field(*credential, "c.perm")),
            param.style.permissions ? "signed document" : "");
  // The kind has one name here, however the peer spells it.
  EXPECT_EQ(as_text(field(*credential, "c.kagree_algo")),
            param.kind == KeyAgreementKind::ecdh_p256   ? "ECDH+prime256v1-CEUM"
            : param.kind == KeyAgreementKind::ecdh_p384 ? "ECDHE-CEUM+P384"
                                                        : "DH+MODP-2048-256");
}

const StyleCase kRepliers[] = {
    {"Standard", {}},
    {"Cyclone", {.optional_fields = false, .nul_terminated = true}},
    {"Fast", {.reversed = true}},
    {"FastWithoutAccessControl", {.permissions = false}},
    {"FastEcLeafUnderRsaCa", {.signature_name = "RSASSA-PSS-SHA256"}},
    {"Rsa", {.signature_name = "RSASSA-PSS-SHA256"}, {}, {}, {KeyKind::rsa, 2048}},
    {"Names12", {.key_agreement_name = "ECDHE-CEUM+P256"}},
};

class ReplierStyle : public testing::TestWithParam<StyleCase> {};

INSTANTIATE_TEST_SUITE_P(Styles, ReplierStyle, testing::ValuesIn(kRepliers),
                         [](const auto& info) { return info.param.name; });

TEST_P(ReplierStyle, ReplyInEachStyle_GetsItsFinal) {
  const auto& param = GetParam();
  TestPlugin plugin;
  Participant us(plugin, ours(), 1);
  HandMadePeer peer(theirs(false, param.spec), 9, param.style);
  const auto remote =
      plugin->validate_remote_identity(us.handle, {}, peer.identity_token(), peer.guid());
  ASSERT_OK(remote);
  EXPECT_EQ(remote->result, ValidationResult::pending_handshake_request);
  const auto request = plugin->begin_handshake_request(us.handle, remote->handle, us.data);
  ASSERT_OK(request);
  const auto final = plugin->process_handshake(request->handle, peer.reply(*request->message));
  ASSERT_OK(final);
  EXPECT_EQ(final->result, ValidationResult::ok_final_message);
  peer.check_final(*final->message, ours().certificate);
  const auto secret = plugin->shared_secret(request->handle);
  ASSERT_OK(secret);
  peer.expect_same_secret(**secret);
}

// In one of 256 handshakes the result of Diffie-Hellman begins with a zero octet. Both sides must
// get the same secret from it.
TEST(HandshakeTokens, ModpSecrets_AgreeManyTimes) {
  TestPlugin plugin;
  Participant us(plugin, ours(), 1);
  const Identity identity = theirs(true);
  for (std::uint8_t i = 0; i < 40; ++i) {
    HandMadePeer peer(identity, i, {.key_agreement_name = kModp});
    const auto remote =
        plugin->validate_remote_identity(us.handle, {}, peer.identity_token(), peer.guid());
    ASSERT_OK(remote);
    const auto reply = plugin->begin_handshake_reply(
        peer.request(KeyAgreementKind::dh_modp_2048_256, PublicKeyEncoding::plain_integer),
        remote->handle, us.handle, us.data);
    ASSERT_OK(reply);
    ASSERT_OK(
        plugin->process_handshake(reply->handle, peer.final(*reply->message, ours().certificate)));
    peer.expect_same_secret(**plugin->shared_secret(reply->handle));
  }
}

TEST(HandshakeTokens, SameSeed_GivesTheSameChallenges) {
  const auto challenge = [] {
    Pairing pairing;
    return field(*pairing.two.request()->message, "challenge1");
  };
  EXPECT_EQ(challenge(), challenge());
}

}  // namespace
}  // namespace ddssec::authentication
