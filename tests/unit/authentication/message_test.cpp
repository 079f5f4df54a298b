// Names, GUIDs, parameter lists, fields and messages on their own.
#include "plugins/authentication/adjusted_guid.hpp"
#include "plugins/authentication/algorithms.hpp"
#include "plugins/authentication/auth_request.hpp"
#include "plugins/authentication/handshake_final.hpp"
#include "plugins/authentication/handshake_reply.hpp"
#include "plugins/authentication/handshake_request.hpp"
#include "plugins/authentication/identity_token.hpp"
#include "plugins/authentication/participant_data.hpp"
#include "tests/unit/authentication/fixture.hpp"

namespace ddssec::authentication {
namespace {

// ---- algorithm names

TEST(Algorithms, OneTrailingNulIsStrippedForComparison) {
  EXPECT_EQ(algorithm_text(bytes("ECDSA-SHA256")), "ECDSA-SHA256");
  EXPECT_EQ(algorithm_text(bytes(std::string_view("A\0", 2))), "A");
  EXPECT_EQ(algorithm_text(bytes(std::string_view("A\0\0", 3))), std::string_view("A\0", 2));
  EXPECT_EQ(algorithm_text({}), "");
}

TEST(Algorithms, WeAnnounceWhatStockPeersUnderstand) {
  EXPECT_EQ(signature_algorithm_name({KeyKind::rsa, 2048}), "RSASSA-PSS-SHA256");
  EXPECT_EQ(signature_algorithm_name({KeyKind::ec_p256, 256}), "ECDSA-SHA256");
  EXPECT_EQ(signature_algorithm_name({KeyKind::ec_p384, 384}), "ECDSA+P384+SHA384");
  EXPECT_EQ(key_agreement_name(pki::KeyAgreementKind::ecdh_p256), "ECDH+prime256v1-CEUM");
  EXPECT_EQ(key_agreement_name(pki::KeyAgreementKind::dh_modp_2048_256), "DH+MODP-2048-256");
}

TEST(Algorithms, UnknownNamesAreNothing) {
  for (const auto name : {"", "ecdsa-sha256", "ECDSA-SHA256 ", "RSASSA-PKCS1-V1_5+2048+SHA256"})
    EXPECT_FALSE(is_signature_algorithm(name)) << name;
  for (const auto name : {"", "AUTO", "DH+MODP-1024", "ECDH+prime256v1-CEUMx"})
    EXPECT_FALSE(key_agreement_kind_from(name)) << name;
}

// ---- adjusted GUID

TEST(AdjustedGuid, HasTheReferenceValue) {
  Guid guid{{}, kEntityIdParticipant};
  for (std::uint8_t i = 0; i < 12; ++i) guid.prefix.octets[i] = static_cast<std::uint8_t>(i + 1);
  const Guid adjusted = adjusted_guid(sha256(as_bytes("abc")), guid);
  EXPECT_EQ(adjusted.to_string(), "dd3c0b5fc7806d4ad050a308.000001c1");
  EXPECT_TRUE(is_adjusted(adjusted));
  EXPECT_TRUE(is_bound_to(adjusted, sha256(as_bytes("abc"))));
}

TEST(AdjustedGuid, EveryOneOfThe48BitsCounts) {
  const auto digest = sha256(as_bytes("abc"));
  const Guid adjusted = adjusted_guid(digest, candidate(1));
  for (std::size_t bit = 0; bit < 96; ++bit) {
    Guid other = adjusted;
    other.prefix.octets[bit / 8] ^= static_cast<std::uint8_t>(0x80u >> (bit % 8));
    EXPECT_EQ(is_bound_to(other, digest), bit >= 48) << bit;
  }
}

// ---- participant data

TEST(ParticipantData, FindsTheGuidAmongParametersOfAnyKind) {
  const auto found = participant_guid_in(participant_data(candidate(7)));
  ASSERT_OK(found);
  EXPECT_EQ(*found, candidate(7));
}

TEST(ParticipantData, ToleratesAMissingSentinelAndARepetition) {
  Bytes data = participant_data(candidate(7));
  data.resize(data.size() - 4);
  EXPECT_TRUE(participant_guid_in(data));
  const Bytes twice = [&] {
    Bytes all = data;
    all.insert(all.end(), data.begin(), data.end());
    return all;
  }();
  EXPECT_TRUE(participant_guid_in(twice));
}

/// RTPS Locator_t in a parameter.
Bytes locator(std::uint16_t id, std::int32_t kind, std::uint32_t port,
              std::initializer_list<std::uint8_t> end) {
  Writer writer;
  writer.write(id);
  writer.write(std::uint16_t{24});
  writer.write(kind);
  writer.write(port);
  Bytes address(16, 0);
  std::ranges::copy(end, address.end() - static_cast<std::ptrdiff_t>(end.size()));
  writer.write_bytes(address);
  return writer.take();
}

TEST(ParticipantData, HasUnicastAddressesOfDiscovery) {
  constexpr std::uint16_t kMetatrafficUnicast = 0x32, kDefaultUnicast = 0x31;
  const auto addresses_in = [](std::initializer_list<Bytes> parameters) {
    Bytes data;
    for (const auto& one : parameters) data.insert(data.end(), one.begin(), one.end());
    const auto rest = participant_data(candidate(7));
    data.insert(data.end(), rest.begin(), rest.end());
    return addresses_in_participant_data(data);
  };
  const auto good = locator(kMetatrafficUnicast, 1, 7410, {10, 0, 0, 1});
  const auto found = addresses_in({good, good});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_FALSE(found[0].is_ipv6);
  EXPECT_EQ(found[0].port, 7410);
  EXPECT_EQ(to_hex(BytesView(found[0].address).subspan(12)), "0a000001");
  EXPECT_TRUE(addresses_in({}).empty());
  for (const auto& bad : {locator(kDefaultUnicast, 1, 7410, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 4, 7410, {10, 0, 0, 1}),     // TCP
                          locator(kMetatrafficUnicast, 1, 0, {10, 0, 0, 1}),        // no port
                          locator(kMetatrafficUnicast, 1, 0x11cf2, {10, 0, 0, 1}),  // nor this
                          locator(kMetatrafficUnicast, 1, 7410, {0, 0, 0, 0}),      // nobody
                          locator(kMetatrafficUnicast, 1, 7410, {239, 255, 0, 1}),  // multicast
                          locator(kMetatrafficUnicast, 1, 7410, {255, 255, 255, 255})})
    EXPECT_TRUE(addresses_in({bad}).empty());
  EXPECT_TRUE(addresses_in({locator(kMetatrafficUnicast, 2, 7410, {1})}).at(0).is_ipv6);
  EXPECT_EQ(addresses_in({locator(kMetatrafficUnicast, 1, 1, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 1, 2, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 1, 3, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 1, 4, {10, 0, 0, 1}),
                          locator(kMetatrafficUnicast, 1, 5, {10, 0, 0, 1})})
                .size(),
            kMostAddresses);
}

TEST(ParticipantData, HasOneBuiltinEndpointSet) {
  const auto set_in = [](BytesView begin) {
    auto data = to_bytes(begin);
    const auto rest = participant_data(candidate(7));
    data.insert(data.end(), rest.begin(), rest.end());
    return builtin_endpoints_in_participant_data(data);
  };
  const Bytes one = {0, 0x58, 0, 4, 0x0f, 0x3f, 0x0c, 0x3f};
  Bytes two = one;
  two.insert(two.end(), one.begin(), one.end());
  EXPECT_EQ(set_in(one), 0x0f3f0c3fu);
  EXPECT_EQ(set_in(two), 0u);
  EXPECT_EQ(set_in({}), 0u);
  EXPECT_EQ(set_in(Bytes{0, 0x58, 0, 2, 0x0f, 0x3f}), 0u);
}

TEST(ParticipantData, RefusesAListThatIsNone) {
  const Bytes one = participant_data(candidate(7));
  Bytes two = one;
  two.resize(two.size() - 4);
  const Bytes other = participant_data(candidate(8));
  two.insert(two.end(), other.begin(), other.end());
  EXPECT_CODE(participant_guid_in(two), participant_data_malformed);
  EXPECT_CODE(participant_guid_in(Bytes{0, 0x50, 0, 8, 1, 2, 3, 4, 5, 6, 7, 8}),
              participant_data_malformed);
  EXPECT_CODE(participant_guid_in(Bytes{0, 0x50, 0, 16, 1}), participant_data_malformed);
  EXPECT_CODE(participant_guid_in(Bytes{0, 0x50, 0}), participant_data_malformed);
  EXPECT_CODE(participant_guid_in(Bytes{}), participant_guid_missing);
  EXPECT_CODE(participant_guid_in(Bytes{0, 1, 0, 0}), participant_guid_missing);
}

TEST(ParticipantData, EveryTruncationIsRefusedOrHarmless) {
  const Bytes whole = participant_data(candidate(7));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto found = participant_guid_in(BytesView(whole).first(size));
    if (found) {
      EXPECT_EQ(*found, candidate(7)) << size;
    }
  }
}

// ---- classes and fields

TEST(TokenClass, NameAndMajorVersionCount) {
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.0"), TokenClass::identity);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.2"), TokenClass::identity);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.0+Req"), TokenClass::request);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.2+Reply"), TokenClass::reply);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.0+Final"), TokenClass::final);
  EXPECT_EQ(token_class_of("DDS:Auth:PKI-DH:1.0+AuthReq"), TokenClass::auth_request);
  for (const auto id :
       {"", "DDS:Auth:PKI-DH", "DDS:Auth:PKI-DH:1.", "DDS:Auth:PKI-DH:2.0", "DDS:Auth:PKI-DH:1.0+",
        "DDS:Auth:PKI-DH:1.0+req", "DDS:Auth:PKI-DH:1.0 ", "dds:Auth:PKI-DH:1.0",
        "DDS:Auth:PKI-DH:1.0000000000", "DDS:Auth:PKI-DH:10.0"})
    EXPECT_FALSE(token_class_of(id)) << id;
}

Token sample() {
  return {.class_id = "DDS:Auth:PKI-DH:1.0+AuthReq",
          .binary_properties = {{"future_challenge", Bytes(32)}}};
}

TEST(TokenFields, ToleratesWhatItDoesNotKnowWithinBounds) {
  Token token = sample();
  token.binary_properties.push_back({"com.example.new", Bytes(kMostUnknownOctets)});
  token.properties.push_back({"note", std::string(kMostTextOctets, 'x')});
  EXPECT_TRUE(read_auth_request(token));
}

TEST(TokenFields, RefusesWhatIsTooMuch) {
  Token unknown = sample();
  unknown.binary_properties.push_back({"x", Bytes(kMostUnknownOctets + 1)});
  EXPECT_CODE(read_auth_request(unknown), token_too_large);
  Token name = sample();
  name.binary_properties.push_back({std::string(kMostTextOctets + 1, 'x'), {}});
  EXPECT_CODE(read_auth_request(name), token_too_large);
  Token text = sample();
  text.properties.push_back({"x", std::string(kMostTextOctets + 1, 'x')});
  EXPECT_CODE(read_auth_request(text), token_too_large);
  Token many = sample();
  for (std::size_t i = 0; i < spi::kMostPropertiesPerToken; ++i)
    many.binary_properties.push_back({std::to_string(i), {}});
  EXPECT_CODE(read_auth_request(many), token_too_large);
  Token ocsp = sample();
  ocsp.binary_properties.push_back({"ocsp_status", Bytes(kMostUnknownOctets + 1)});
  EXPECT_CODE(read_auth_request(ocsp), token_too_large);
}

TEST(AuthRequest, RoundTrips) {
  Challenge challenge;
  challenge.fill(7);
  const auto read = read_auth_request(write_auth_request(challenge));
  ASSERT_OK(read);
  EXPECT_EQ(*read, challenge);
}

TEST(AuthRequest, Refusals) {
  Token wrong_class = sample();
  wrong_class.class_id = "DDS:Auth:PKI-DH:1.0+Req";
  EXPECT_CODE(read_auth_request(wrong_class), token_class_wrong);
  EXPECT_CODE(read_auth_request(without(sample(), "future_challenge")), token_field_missing);
  for (const std::size_t size : {0u, 31u, 33u})
    EXPECT_CODE(read_auth_request(with(sample(), "future_challenge", Bytes(size))),
                token_field_length);
  Token twice = sample();
  twice.binary_properties.push_back(twice.binary_properties[0]);
  EXPECT_CODE(read_auth_request(twice), token_field_repeated);
}

TEST(IdentityToken, SpeaksCyclonesWords) {
  const auto identity = make_identity(test_ca(), "CN=alice,O=Example");
  const auto token =
      write_identity_token(identity.certificate, test_ca().certificate(), spi::kStandardCiphers);
  EXPECT_EQ(token.class_id, "DDS:Auth:PKI-DH:1.0");
  const PropertyList expected = {{"dds.cert.sn", "/O=Example/CN=alice"},
                                 {"dds.cert.algo", "EC-prime256v1"},
                                 {"dds.ca.sn", "/O=Example/CN=Identity CA"},
                                 {"dds.ca.algo", "EC-prime256v1"}};
  EXPECT_EQ(token.properties, expected);
  EXPECT_EQ(read_identity_token(token)->subject, "/O=Example/CN=alice");
}

TEST(IdentityToken, AnnouncesCiphersThatAreNotTheStandards) {
  const auto identity = make_identity(test_ca(), "CN=alice,O=Example");
  const auto& ca = test_ca().certificate();
  const auto token = write_identity_token(identity.certificate, ca, spi::kAllCiphers);
  ASSERT_EQ(token.properties.size(), 5u);
  EXPECT_EQ(token.properties[4],
            (spi::Property{"org.ddssec.symmetric_ciphers", "org.ddssec.ChaCha20-Poly1305"}));
  EXPECT_EQ(announced_ciphers(token), spi::kAllCiphers);
  EXPECT_EQ(announced_ciphers({}), spi::kStandardCiphers);
  auto other = token;
  other.properties[4].value = "com.example.Cipher";
  EXPECT_EQ(announced_ciphers(other), spi::kStandardCiphers);
}

TEST(IdentityToken, InParticipantDataSaysWhatCounts) {
  Token token{"DDS:Auth:PKI-DH:1.0"};
  token.properties.push_back({"org.ddssec.symmetric_ciphers", "org.ddssec.ChaCha20-Poly1305"});
  const auto data = participant_data(candidate(7), &token);
  EXPECT_EQ(ciphers_in_participant_data(data), spi::kAllCiphers);
  EXPECT_EQ(ciphers_in_participant_data(participant_data(candidate(7))), spi::kStandardCiphers);
  EXPECT_EQ(ciphers_in_participant_data({}), spi::kStandardCiphers);
  // Two of them, or half of one, announce nothing.
  auto twice = data;
  twice.resize(twice.size() - 4);
  twice.insert(twice.end(), data.begin(), data.end());
  EXPECT_EQ(ciphers_in_participant_data(twice), spi::kStandardCiphers);
  for (std::size_t size = 0; size < data.size(); ++size) {
    const auto seen = ciphers_in_participant_data(BytesView(data).first(size));
    EXPECT_TRUE(seen == spi::kStandardCiphers || seen == spi::kAllCiphers) << size;
  }
}

TEST(IdentityToken, PropertiesMayBeAbsentTheClassMayNot) {
  EXPECT_TRUE(read_identity_token({"DDS:Auth:PKI-DH:1.2"}));
  EXPECT_CODE(read_identity_token({"DDS:Auth:Other:1.0"}), token_class_wrong);
  EXPECT_CODE(read_identity_token({"DDS:Auth:PKI-DH:1.0+Req"}), token_class_wrong);
  EXPECT_CODE(read_identity_token({""}), token_class_wrong);
}

// ---- hashes and signature inputs, against the vectors of the reference

Credentials vector_a() {
  static const Bytes id = bytes("-----BEGIN"), permissions = bytes("P"), data = {0, 1, 0, 0},
                     signature = bytes("ECDSA-SHA256"), agreement = bytes("ECDH+prime256v1-CEUM");
  return {id, permissions, data, signature, agreement, {}};
}

TEST(Hashes, HaveTheReferenceValue) {
  EXPECT_EQ(to_hex(vector_a().hash()),
            "f436fdded2a5dbcbf37a027eb2f6cc06eb9c4aeefdc47b9cdfd47847fd3222d7");
}

TEST(Hashes, AbsentPermissionsAreNotEmptyPermissions) {
  auto absent = vector_a();
  absent.permissions.reset();
  auto empty = vector_a();
  empty.permissions = BytesView();
  EXPECT_NE(absent.hash(), empty.hash());
}

TEST(SignatureInput, NamesTheSixValuesInTheStandardsOrder) {
  const Transcript transcript{.dh1 = {1}, .dh2 = {2}};
  const auto reply = transcript.reply_input();
  const auto final = transcript.final_input();
  EXPECT_EQ(reply.size(), final.size());
  const auto order = [](BytesView octets, std::vector<std::string_view> names) {
    std::size_t at = 0;
    for (const auto name : names) {
      const auto found = as_text(octets).find(name, at);
      ASSERT_NE(found, std::string_view::npos) << name;
      at = found;
    }
  };
  order(reply, {"hash_c2", "challenge2", "dh2", "challenge1", "dh1", "hash_c1"});
  order(final, {"hash_c1", "challenge1", "dh1", "challenge2", "dh2", "hash_c2"});
}

// ---- truncation: the wire form of every message, cut anywhere, is refused by the token reader

class Truncation : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Messages, Truncation, testing::Values("Req", "Reply", "Final", "AuthReq"));

TEST_P(Truncation, AtEveryOctetIsRefused) {
  Pairing pairing;
  const auto req = pairing.two.request();
  const auto rep = pairing.two.reply(*req->message);
  const auto fin = pairing.two.at_low(req->handle, *rep->message);
  ASSERT_OK(fin);
  const std::map<std::string, Token> tokens = {{"Req", *req->message},
                                               {"Reply", *rep->message},
                                               {"Final", *fin->message},
                                               {"AuthReq", sample()}};
  for (const auto endian : {Endian::little, Endian::big}) {
    Writer writer(endian);
    spi::write_token(writer, tokens.at(GetParam()));
    for (std::size_t size = 0; size < writer.size(); ++size) {
      Reader reader(writer.view().first(size), endian);
      EXPECT_FALSE(spi::read_token(reader)) << size;
    }
    Reader reader(writer.view(), endian);
    EXPECT_EQ(*spi::read_token(reader), tokens.at(GetParam()));
  }
}

}  // namespace
}  // namespace ddssec::authentication
